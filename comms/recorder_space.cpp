// The part of RecorderDisk that finds room: who gives way to whom when the disk fills up.
#include <algorithm>

#include "comms/log_files.hpp"
#include "comms/recorder_disk.hpp"

namespace kawara::comms {
namespace {

std::string MiB(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

}  // namespace

void RecorderDisk::MakeReserve() {
  if (config_.navigation_reserve_bytes == 0) return;
  const std::filesystem::path path = folder_ / kReserveName;
  auto file = disk_->Create(path);
  auto ok = file ? (*file)->Allocate(config_.navigation_reserve_bytes) : core::Expected<void>();
  if (!file) ok = tl::unexpected(file.error());
  has_reserve_ = ok.has_value();
  if (has_reserve_) return;
  if (file) (void)disk_->Remove(path);
  announce_(1, "recorder.no_reserve", "no reserve for navigation: " + ok.error().message);
}

// In this order: the oldest pictures on the disk, then pictures at all, then the reserve. Pictures
// only get the first.
bool RecorderDisk::MakeRoom(RecordClass content) {
  if (DeleteOldestPictures(0)) return true;
  if (content == RecordClass::kPictures) return false;
  if (!pictures_paused_) {
    PausePictures("the disk is full");
    (void)DeleteOldestPictures(0);
    return true;
  }
  if (!has_reserve_) return false;
  has_reserve_ = false;
  const auto removed = disk_->Remove(folder_ / kReserveName);
  announce_(2, "recorder.reserve_used",
            "the disk is full: navigation goes on in its reserve of " +
                MiB(config_.navigation_reserve_bytes));
  return removed.has_value();
}

void RecorderDisk::PausePictures(const std::string& why) {
  if (pictures_paused_) return;
  pictures_paused_ = true;
  Track& pictures = track(RecordClass::kPictures);
  pictures.waiting = false;
  GiveUpUnsynced(pictures);
  announce_(2, "recorder.pictures_paused", why + ": no pictures are recorded until there is room");
}

// Over all missions, by name: missions are called after their time, segments are numbered. Only
// files called as the recorder calls them, in folders that hold navigation of the recorder, and
// never the one being written.
std::optional<std::filesystem::path> RecorderDisk::OldestPictures() {
  const Track& pictures = track(RecordClass::kPictures);
  for (const std::filesystem::path& mission : disk_->List(config_.folder)) {
    const std::vector<std::filesystem::path> files = disk_->List(mission);
    const auto is = [](const char* content) {
      return
          [content](const std::filesystem::path& file) { return SegmentContent(file) == content; };
    };
    if (std::ranges::none_of(files, is("navigation"))) continue;
    const auto oldest = std::ranges::find_if(files, is("pictures"));
    if (oldest == files.end() || (pictures.writer && *oldest == pictures.writer->path())) continue;
    return *oldest;
  }
  return std::nullopt;
}

bool RecorderDisk::DeleteOldestPictures(std::uint64_t free_bytes) {
  const auto oldest = OldestPictures();
  if (!oldest) return false;
  const std::uint64_t before = disk_->FreeBytes(config_.folder).value_or(0);
  if (auto ok = disk_->Remove(*oldest); !ok) {
    announce_(1, "recorder.delete_failed", ok.error().message);
    return false;
  }
  const std::uint64_t after = disk_->FreeBytes(config_.folder).value_or(before);
  ++deleted_segments_;
  deleted_bytes_ += after > before ? after - before : 0;
  announce_(
      1, "recorder.pictures_deleted",
      "disk low (" + MiB(free_bytes) + " free): the oldest pictures gave way, " + oldest->string());
  return true;
}

void RecorderDisk::WatchFreeSpace(core::MonoTime now) {
  auto free_bytes = disk_->FreeBytes(config_.folder);
  while (free_bytes && *free_bytes < config_.disk_reserve_bytes &&
         DeleteOldestPictures(*free_bytes)) {
    free_bytes = disk_->FreeBytes(config_.folder);
  }
  if (!free_bytes) return;
  if (*free_bytes < config_.disk_reserve_bytes) {
    PausePictures("only " + MiB(*free_bytes) +
                  " free on the disk and no old pictures left to delete");
    return;
  }
  const std::uint64_t comfortable = config_.disk_reserve_bytes + config_.disk_reserve_bytes / 8;
  if (*free_bytes < comfortable + (has_reserve_ ? 0 : config_.navigation_reserve_bytes)) return;
  if (!has_reserve_ && !track(RecordClass::kNavigation).waiting) MakeReserve();
  if (pictures_paused_) {
    pictures_paused_ = false;
    if (Settle(track(RecordClass::kPictures), now)) {
      announce_(0, "recorder.pictures_resumed",
                "pictures are recorded again, " + MiB(*free_bytes) + " free");
    }
  }
}

}  // namespace kawara::comms
