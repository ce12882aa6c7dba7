#include "vision/png_error.hpp"

#include <cstdio>

namespace kawara::vision {

void GiveUpPng(png_structp png, png_const_charp message) {
  auto* error = static_cast<PngError*>(png_get_error_ptr(png));
  std::snprintf(error->message, sizeof error->message, "%s", message);
  std::longjmp(error->back, 1);
}

void IgnorePngWarning(png_structp, png_const_charp) {}

}  // namespace kawara::vision
