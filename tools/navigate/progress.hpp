#pragma once
#include <string>

#include "core/time.hpp"

namespace kawara::navigate {

/// A bar on the terminal while a run takes longer than a second; nothing where standard error is no
/// terminal. Gone when done. One thread.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap enough for every sample. `part` gives 0..1 and is asked now and then.
  template <class Part>
  void Tick(Part part) {
    if (terminal_ && ++ticks_ % 1024 == 0) Show(part());
  }

 private:
  void Show(double part);

  bool terminal_;
  core::MonoTime start_;
  unsigned ticks_ = 0;
  int shown_percent_ = -1;
};

}  // namespace kawara::navigate
