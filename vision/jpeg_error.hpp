#pragma once
#include <csetjmp>
#include <cstddef>
#include <cstdio>
// jpeglib.h uses size_t and FILE without including them: it must come after the two above.
// clang-format off
#include <jpeglib.h>
// clang-format on

/// How libjpeg's errors come back: by longjmp into the function that called it. Such a function
/// keeps nothing with a destructor on its stack between setjmp and the last libjpeg call;
/// everything lives in its Impl.
namespace kawara::vision {

struct JpegError {
  jpeg_error_mgr base;  ///< first, so that libjpeg's pointer to it is a pointer to the whole
  std::jmp_buf back;
  char message[JMSG_LENGTH_MAX];
};

/// Prepares `error` and returns what belongs into cinfo.err. Warnings are counted in
/// base.num_warnings, silently.
jpeg_error_mgr* InstallJpegError(JpegError* error);

/// Gives up from inside a libjpeg callback, with our own words.
[[noreturn]] void GiveUpJpeg(j_common_ptr info, const char* message);

}  // namespace kawara::vision
