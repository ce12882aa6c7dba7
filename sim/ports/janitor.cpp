#include "sim/ports/janitor.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>

namespace kawara::sim {
namespace {

/// The janitor's life. Other threads may have held locks when it was made, so it only calls what
/// POSIX allows then: no allocation.
[[noreturn]] void Wait(int pipe, const std::vector<std::string>& files) {
  setsid();  // a terminal's Ctrl-C, or a kill of the group, is not for us
  // Pseudo-terminals must close with their owner, and nobody waits for our output.
  if (pipe != 0) dup2(pipe, 0);
  close_range(1, ~0U, 0);
  char word = 0;
  ssize_t n = 0;
  do {
    n = read(0, &word, 1);
  } while (n < 0 && errno == EINTR);
  if (n == 0) {  // nobody said goodbye
    for (const std::string& file : files) unlink(file.c_str());
  }
  _exit(0);
}

}  // namespace

Janitor::Janitor(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(std::filesystem::absolute(file).string());
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return;
  process_ = fork();
  if (process_ == 0) {
    close(ends[1]);
    Wait(ends[0], names);
  }
  close(ends[0]);
  pipe_ = ends[1];
}

Janitor::~Janitor() {
  if (process_ <= 0) {
    if (pipe_ >= 0) close(pipe_);
    return;
  }
  const char goodbye = 'q';
  (void)!write(pipe_, &goodbye, 1);
  close(pipe_);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace kawara::sim
