#pragma once
#include "core/expected.hpp"
#include "tools/navigate/options.hpp"

namespace kawara::navigate {

/// How it went wrong: the exit status and one line.
struct Failure {
  int status = 2;  ///< 2: what was asked for or read; 1: what could not be written
  std::string message;
};

/// The whole program behind the command line: reads, navigates, writes, prints the table on
/// standard output and remarks on standard error.
tl::expected<void, Failure> Navigate(const Options& options);

}  // namespace kawara::navigate
