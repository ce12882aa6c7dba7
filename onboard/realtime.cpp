#include "onboard/realtime.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace kawara::onboard {

RealtimeComplaints LockMemory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return {std::string("memory is not locked (") + std::strerror(errno) +
          "): raise the limit with 'ulimit -l unlimited' or LimitMEMLOCK=infinity in the unit"};
}

RealtimeComplaints BecomeRealtime(const char* thread_name, int priority) {
  pthread_setname_np(pthread_self(), thread_name);
  sched_param param{};
  param.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (error == 0) return {};
  return {std::string(thread_name) + " runs without real-time priority (" + std::strerror(error) +
          "): raise the limit with 'ulimit -r 80' or LimitRTPRIO=80 in the unit"};
}

void BecomeBackground(const char* thread_name, int nice_level) {
  pthread_setname_np(pthread_self(), thread_name);
  // Linux applies nice per thread when given a thread id. Failure leaves normal priority: harmless.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice_level);
}

}  // namespace kawara::onboard
