#pragma once
#include <sys/types.h>

#include <filesystem>
#include <vector>

namespace kawara::sim {

/// Takes away files that must not outlive this process, even if it is killed with SIGKILL: a small
/// process of its own waits for the end of this one, removes what is left of them, and ends. Where
/// no process can be made there is none, and nothing else changes.
class Janitor {
 public:
  explicit Janitor(const std::vector<std::filesystem::path>& files);
  ~Janitor();  ///< sends the process away; the files are then the owner's own matter
  Janitor(const Janitor&) = delete;
  Janitor& operator=(const Janitor&) = delete;

 private:
  int pipe_ = -1;  ///< closes with this process
  pid_t process_ = -1;
};

}  // namespace kawara::sim
