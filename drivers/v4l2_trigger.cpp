#include "drivers/v4l2_trigger.hpp"

#include <pthread.h>

#include <utility>

namespace kawara::drivers {

V4l2TriggerThread::V4l2TriggerThread(std::function<void()> pull)
    : pull_(std::move(pull)), thread_([this] { Run(); }) {}

V4l2TriggerThread::~V4l2TriggerThread() {
  stopping_.store(true);
  Fire();
  thread_.join();
}

void V4l2TriggerThread::Fire() {
  ordered_.fetch_add(1);
  ordered_.notify_one();
}

void V4l2TriggerThread::Run() {
  pthread_setname_np(pthread_self(), "v4l2-trigger");
  std::uint32_t done = 0;
  for (;;) {
    ordered_.wait(done);
    done = ordered_.load();
    if (stopping_.load()) return;
    pull_();
  }
}

}  // namespace kawara::drivers
