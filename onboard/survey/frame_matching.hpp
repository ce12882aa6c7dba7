#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "onboard/survey/pose_table.hpp"

namespace kawara::survey {

/// The pictures of a camera, sorted by name (numbers by their value). `where` is a folder, or a
/// pattern with * and ? in its last part. Errors: kNotFound.
core::Expected<std::vector<std::filesystem::path>> ListPictures(const std::filesystem::path& where);

/// Which picture belongs to which row of poses; -1: none. By the rows' names where they have some
/// (the file's name with or without ending or folder; numbers by their value), else by stamps where
/// the pictures are named by them, else by order.
/// Errors: kFormat, if by order there are not as many of both.
core::Expected<std::vector<int>> MatchPictures(const std::vector<PoseRow>& rows,
                                               const std::string& camera,
                                               const std::vector<std::filesystem::path>& pictures);

}  // namespace kawara::survey
