#include "onboard/picture_worker.hpp"

#include <utility>

#include "onboard/realtime.hpp"

namespace kawara::onboard {

PictureWorker::PictureWorker(Phase1Assembler assembler, FrameTable& frames, InputInbox& inbox)
    : assembler_(std::move(assembler)),
      frames_(frames),
      inbox_(inbox),
      thread_([this] { Run(); }) {}

PictureWorker::~PictureWorker() { Stop(); }

void PictureWorker::Add(const PictureOrder& order) {
  const std::lock_guard lock(mutex_);
  queue_.emplace_back(order);
  wake_.notify_one();
}

void PictureWorker::Add(const ExposurePose& pose) {
  const std::lock_guard lock(mutex_);
  queue_.emplace_back(pose);
  wake_.notify_one();
}

void PictureWorker::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    wake_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

void PictureWorker::Run() {
  BecomeBackground("pictures", 2);
  std::int64_t reported = 0;
  bool more = false;
  std::unique_lock lock(mutex_);
  for (;;) {
    if (!more) wake_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty() && !more) return;
    const auto news = std::exchange(queue_, {});
    lock.unlock();
    for (const auto& item : news) Take(item);
    more = assembler_.Work();
    for (; reported < assembler_.stats().finished; ++reported) {
      inbox_.Post(InputKind::kPictureDone, core::MonoNow(), {});
    }
    lock.lock();
  }
}

void PictureWorker::Take(const std::variant<PictureOrder, ExposurePose>& item) {
  if (const auto* order = std::get_if<PictureOrder>(&item)) {
    if (auto frame = frames_.Get(order->slot)) assembler_.OnFrame(order->epoch, std::move(frame));
    frames_.Release(order->slot);
  } else {
    assembler_.OnPose(std::get<ExposurePose>(item));
  }
}

}  // namespace kawara::onboard
