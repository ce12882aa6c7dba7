#include "drivers/serial_diagnosis.hpp"

#include <grp.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

namespace kawara::drivers {
namespace {

namespace fs = std::filesystem;

/// Full paths of the entries of `folder` whose names begin with `prefix`, sorted. Empty if there is
/// no folder.
std::vector<std::string> EntriesOf(const char* folder, std::string_view prefix) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().filename().string().starts_with(prefix)) found.push_back(it->path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// The kernel makes ttyS0..3 whether or not a UART is there; its type (0: none) is asked of sysfs,
/// because opening the port would pull its RTS and DTR.
bool HasUart(const fs::path& port) {
  std::ifstream type("/sys/class/tty/" + port.filename().string() + "/type");
  int number = 0;
  return (type >> number) && number != 0;
}

std::string PortsHere() {
  std::string text;
  for (const std::string& port : ListSerialPorts()) text += (text.empty() ? "" : ", ") + port;
  return text.empty() ? "no serial port is plugged in" : "serial ports here: " + text;
}

std::string ProcessName(const std::string& pid) {
  std::ifstream comm("/proc/" + pid + "/comm");
  std::string name;
  std::getline(comm, name);
  return (name.empty() ? "" : name + " ") +
         (name.empty() ? "process " + pid : "(process " + pid + ")");
}

bool IsNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// By open descriptors: shows our own processes, and everybody's to root.
std::string HolderByDescriptors(const std::string& real_path) {
  const std::string self = std::to_string(getpid());
  std::error_code error;
  for (fs::directory_iterator proc("/proc", error), end; !error && proc != end;
       proc.increment(error)) {
    const std::string pid = proc->path().filename().string();
    if (!IsNumber(pid) || pid == self) continue;
    std::error_code denied;
    for (fs::directory_iterator fd(proc->path() / "fd", denied);
         !denied && fd != fs::directory_iterator(); fd.increment(denied)) {
      std::error_code gone;
      if (fs::read_symlink(fd->path(), gone) == real_path) return ProcessName(pid);
    }
  }
  return "";
}

/// By the table of file locks, which everybody may read.
std::string HolderByLocks(const std::string& real_path) {
  struct stat info {};
  if (stat(real_path.c_str(), &info) != 0) return "";
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    // 1: FLOCK  ADVISORY  WRITE 1234 00:18:5 0 EOF
    std::istringstream fields(line);
    std::string number, kind, advisory, access, pid, inode;
    fields >> number >> kind >> advisory >> access >> pid >> inode;
    const std::size_t colon = inode.rfind(':');
    if (colon == std::string::npos || !IsNumber(pid)) continue;
    if (inode.substr(colon + 1) != std::to_string(info.st_ino)) continue;
    unsigned major_number = 0, minor_number = 0;
    std::from_chars(inode.data(), inode.data() + 2, major_number, 16);
    std::from_chars(inode.data() + 3, inode.data() + colon, minor_number, 16);
    if (makedev(major_number, minor_number) == info.st_dev) return ProcessName(pid);
  }
  return "";
}

std::string PermissionCure(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return "(may this user look into its folder?)";
  const group* owner = getgrgid(info.st_gid);
  const bool group_may = (info.st_mode & 0060U) == 0060U && info.st_gid != 0;
  if (group_may && owner != nullptr) {
    const std::string name = owner->gr_name;
    return "(add the user to group " + name + ": sudo usermod -aG " + name +
           " $USER, then log in again)";
  }
  return "(only its owner may use it: add the user to group dialout and give the device to that "
         "group by udev)";
}

const char* KindOf(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return "an unknown thing";
  switch (info.st_mode & static_cast<mode_t>(S_IFMT)) {
    case S_IFREG:
      return "a file";
    case S_IFDIR:
      return "a directory";
    case S_IFIFO:
      return "a pipe";
    case S_IFSOCK:
      return "a socket";
    case S_IFBLK:
      return "a block device";
    default:
      return "another kind of device";
  }
}

}  // namespace

std::vector<std::string> ListSerialPorts() {
  std::vector<std::string> ports = EntriesOf("/dev/serial/by-id", "");
  for (const char* prefix : {"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS"}) {
    for (std::string& port : EntriesOf("/dev", prefix)) ports.push_back(std::move(port));
  }
  for (std::string& port : EntriesOf("/dev", "ttyS")) {
    if (HasUart(port)) ports.push_back(std::move(port));
  }
  return ports;
}

std::string WhoHolds(const std::string& path) {
  std::error_code error;
  const std::string real_path = fs::canonical(path, error).string();
  if (error) return "";
  const std::string holder = HolderByDescriptors(real_path);
  return holder.empty() ? HolderByLocks(real_path) : holder;
}

core::Error OpenError(const std::string& path, int errno_value) {
  core::Error error = core::ErrnoError("open " + path, errno_value);
  switch (errno_value) {
    case ENOENT:
    case ENOTDIR:
    case ELOOP:
      error.code = core::ErrorCode::kNotFound;
      error.message = "open " + path + ": no such device (plugged in? " + PortsHere() + ")";
      break;
    case ENODEV:
    case ENXIO:
      error.message += " (nothing is plugged in behind this name; " + PortsHere() + ")";
      break;
    case EACCES:
    case EPERM:
      error.message += ' ' + PermissionCure(path);
      break;
    case EBUSY:
    case EWOULDBLOCK: {
      const std::string holder = WhoHolds(path);
      error.code = core::ErrorCode::kUnavailable;
      error.message = "open " + path + ": in use by " +
                      (holder.empty() ? "another program" : holder) +
                      " (stop it, or give this instrument another port)";
      break;
    }
    case EIO:
      error.message += " (the name exists, but no hardware answers behind it; " + PortsHere() + ")";
      break;
    default:
      break;
  }
  return error;
}

core::Error NotSerialError(const std::string& path) {
  return {core::ErrorCode::kInvalidArgument,
          "open " + path + ": not a serial port but " + KindOf(path) + " (" + PortsHere() + ")"};
}

}  // namespace kawara::drivers
