#include "vision/jpeg_error.hpp"

namespace kawara::vision {
namespace {

[[noreturn]] void Exit(j_common_ptr info) {
  auto* error = reinterpret_cast<JpegError*>(info->err);
  error->base.format_message(info, error->message);
  std::longjmp(error->back, 1);
}

void Warn(j_common_ptr info, int level) {
  if (level < 0) ++info->err->num_warnings;  // levels from 0 up are traces
}

void Silent(j_common_ptr) {}

}  // namespace

void GiveUpJpeg(j_common_ptr info, const char* message) {
  auto* error = reinterpret_cast<JpegError*>(info->err);
  std::snprintf(error->message, sizeof error->message, "%s", message);
  std::longjmp(error->back, 1);
}

jpeg_error_mgr* InstallJpegError(JpegError* error) {
  jpeg_std_error(&error->base);
  error->base.error_exit = Exit;
  error->base.emit_message = Warn;
  error->base.output_message = Silent;
  error->message[0] = '\0';
  return &error->base;
}

}  // namespace kawara::vision
