#pragma once
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <string>

/// Programs of ours, run as a user runs them.
namespace kawara::vm {

struct Answer {
  int status = -1;
  std::string text;  ///< standard output and error
};

inline Answer Command(const std::string& command_line) {
  const std::string programs = std::filesystem::canonical("/proc/self/exe").parent_path().string();
  Answer answer;
  FILE* const pipe = popen((programs + "/" + command_line + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return answer;
  char line[4096];
  while (std::fgets(line, sizeof line, pipe) != nullptr) answer.text += line;
  const int status = pclose(pipe);
  answer.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return answer;
}

inline bool Has(const Answer& answer, const std::string& part) {
  return answer.text.find(part) != std::string::npos;
}

}  // namespace kawara::vm
