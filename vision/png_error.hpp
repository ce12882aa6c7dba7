#pragma once
#include <png.h>

#include <csetjmp>

/// How libpng's errors come back: by longjmp into the function that called it. Such a function
/// keeps nothing with a destructor on its stack between setjmp and the last libpng call;
/// everything lives in its state. (As jpeg_error.hpp has it for libjpeg.)
namespace kawara::vision {

struct PngError {
  std::jmp_buf back;
  char message[96] = "";  ///< libpng's own words
};

/// libpng's callbacks: keeps the words and jumps. png_get_error_ptr must be a PngError.
[[noreturn]] void GiveUpPng(png_structp png, png_const_charp message);
/// Warnings are of no consequence: what matters is an error.
void IgnorePngWarning(png_structp png, png_const_charp message);

}  // namespace kawara::vision
