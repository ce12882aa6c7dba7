#pragma once
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <variant>

#include "onboard/frame_table.hpp"
#include "onboard/input_inbox.hpp"
#include "onboard/phase1_assembler.hpp"

namespace kawara::onboard {

/// Runs a Phase1Assembler on a thread of its own, below everything that has a deadline. Orders and
/// poses are handed in by the pump and looked for between any two pieces of work; each finished
/// picture is reported back to the core (kPictureDone), which keeps the queue bounded.
class PictureWorker {
 public:
  PictureWorker(Phase1Assembler assembler, FrameTable& frames, InputInbox& inbox);
  ~PictureWorker();  ///< Stop()
  PictureWorker(const PictureWorker&) = delete;
  PictureWorker& operator=(const PictureWorker&) = delete;

  void Add(const PictureOrder& order);
  void Add(const ExposurePose& pose);
  /// Finishes what is queued, then ends.
  void Stop();

 private:
  void Run();
  void Take(const std::variant<PictureOrder, ExposurePose>& item);

  Phase1Assembler assembler_;
  FrameTable& frames_;
  InputInbox& inbox_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::variant<PictureOrder, ExposurePose>> queue_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace kawara::onboard
