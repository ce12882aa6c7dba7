#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <kawara/frame_t.hpp>
#include <kawara/phase1_t.hpp>
#include <memory>
#include <set>
#include <unordered_map>

#include "comms/codec.hpp"
#include "tools/log_common.hpp"

namespace kawara::tools {
namespace {

/// Path of every leaf of a message: the columns. Variable arrays have as many columns as the
/// longest needs.
class Columns : public comms::LcmVisitor {
 public:
  void Start() { after_ = 0; }
  const std::vector<std::string>& names() const { return names_; }

  void Integer(std::string_view path, comms::LcmKind, std::int64_t) override { Note(path); }
  void Real(std::string_view path, double) override { Note(path); }
  void Text(std::string_view path, std::string_view) override { Note(path); }
  void Bytes(std::string_view path, std::span<const std::uint8_t>) override { Note(path); }

 private:
  // A new one belongs behind the one before it in this message.
  void Note(std::string_view path) {
    if (after_ < names_.size() && names_[after_] == path) {
      ++after_;
      return;
    }
    const auto known = std::find(names_.begin(), names_.end(), path);
    if (known != names_.end()) {
      after_ = static_cast<std::size_t>(known - names_.begin()) + 1;
      return;
    }
    names_.insert(names_.begin() + static_cast<std::ptrdiff_t>(after_), std::string(path));
    ++after_;
  }
  std::vector<std::string> names_;
  std::size_t after_ = 0;
};

bool HasVariableColumns(const comms::LcmType& type) {
  return std::ranges::any_of(type.members(), [](const comms::LcmType::Member& m) {
    const bool variable =
        m.kind != comms::LcmKind::kByte &&
        std::ranges::any_of(m.dimensions, [](const auto& d) { return d.count_slot >= 0; });
    return variable || (m.struct_type != nullptr && HasVariableColumns(*m.struct_type));
  });
}

/// One line of the CSV (RFC 4180).
class Row : public comms::LcmVisitor {
 public:
  explicit Row(const std::vector<std::string>& columns) : cells_(columns.size()) {
    for (std::size_t i = 0; i < columns.size(); ++i) index_.emplace(columns[i], i);
  }
  void Start(bool picture) {
    std::ranges::for_each(cells_, [](std::string& cell) { cell.clear(); });
    picture_ = picture;
  }
  /// What the bytes of a picture's column show instead of the bytes.
  void SetPicture(std::string file) { picture_file_ = std::move(file); }
  void AppendTo(std::string& line) const {
    for (const std::string& cell : cells_) line += ',' + cell;
    line += "\r\n";
  }

  void Integer(std::string_view path, comms::LcmKind, std::int64_t value) override {
    Cell(path) = Number(value);
  }
  void Real(std::string_view path, double value) override { Cell(path) = Number(value); }
  void Text(std::string_view path, std::string_view value) override {
    std::string& cell = Cell(path);
    if (value.find_first_of(",\"\r\n") == std::string_view::npos) {
      cell = value;
      return;
    }
    cell = '"';
    for (const char c : value) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
    cell += '"';
  }
  void Bytes(std::string_view path, std::span<const std::uint8_t> value) override {
    std::string& cell = Cell(path);
    if (picture_) {
      cell = picture_file_;
      return;
    }
    constexpr std::string_view kHex = "0123456789abcdef";
    cell.reserve(2 * value.size());
    for (const std::uint8_t b : value) {
      cell += kHex[b >> 4];
      cell += kHex[b & 0xfU];
    }
  }

 private:
  template <class T>
  static std::string Number(T value) {
    std::array<char, 32> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end};
  }
  std::string& Cell(std::string_view path) {
    const auto it = index_.find(std::string(path));
    return it == index_.end() ? spare_ : cells_[it->second];
  }
  std::unordered_map<std::string, std::size_t> index_;
  std::vector<std::string> cells_;
  std::string spare_;
  std::string picture_file_;
  bool picture_ = false;
};

class OutputFile {
 public:
  static core::Expected<OutputFile> Open(const std::string& path) {
    if (path == "-") return OutputFile(stdout, "standard output");
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return tl::unexpected(core::ErrnoError("write " + path, errno));
    return OutputFile(file, path);
  }
  [[nodiscard]] core::Expected<void> Write(const void* data, std::size_t size) {
    if (std::fwrite(data, 1, size, file_.get()) != size)
      return tl::unexpected(core::ErrnoError("write " + path_, errno));
    return {};
  }
  [[nodiscard]] core::Expected<void> Close() {
    std::FILE* file = file_.release();
    const bool ok = file == stdout ? std::fflush(file) == 0 : std::fclose(file) == 0;
    if (!ok) return tl::unexpected(core::ErrnoError("write " + path_, errno));
    return {};
  }

 private:
  struct Closer {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  OutputFile(std::FILE* file, std::string path) : file_(file), path_(std::move(path)) {}
  std::unique_ptr<std::FILE, Closer> file_;
  std::string path_;
};

struct Picture {
  std::string name;
  std::string header;  ///< of a Netpbm file, for raw pixels
  std::vector<std::uint8_t> bytes;
};

std::string Numbered(const char* what, std::int64_t number) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%s-%06lld", what, static_cast<long long>(number));
  return text.data();
}

// JPEG as it is; raw pixels become PPM or PGM if there are as many as the size says.
std::optional<Picture> PictureIn(std::span<const std::uint8_t> message) {
  if (auto phase1 = comms::Decode<phase1_t>(message)) {
    const char* stage = phase1->stage == 0 ? "-preview.jpg" : "-full.jpg";
    return Picture{Numbered("phase1", phase1->epoch) + stage, {}, std::move(phase1->jpeg)};
  }
  auto frame = comms::Decode<frame_t>(message);
  if (!frame || frame->data.empty()) return std::nullopt;
  const std::string name = Numbered("frame", frame->sequence);
  if (frame->format == 1) return Picture{name + ".jpg", {}, std::move(frame->data)};
  const std::int64_t channels = frame->format == 2 ? 3 : 1;
  const std::int64_t pixels = std::int64_t{frame->width} * frame->height;
  if (frame->format < 2 || frame->format > 3 || frame->width <= 0 || frame->height <= 0 ||
      pixels * channels != frame->n) {
    return std::nullopt;
  }
  return Picture{name + (channels == 3 ? ".ppm" : ".pgm"),
                 std::string(channels == 3 ? "P6 " : "P5 ") + std::to_string(frame->width) + " " +
                     std::to_string(frame->height) + " 255\n",
                 std::move(frame->data)};
}

/// The first pass: which type is on the channel, and its columns.
struct Layout {
  std::string type_name;
  std::int64_t fingerprint = 0;
  Columns columns;
  std::uint64_t messages = 0;
};

core::Expected<Layout> FindLayout(const std::vector<std::string>& paths,
                                  const std::string& channel) {
  auto reader = OpenLogs(paths);
  if (!reader) return tl::unexpected(reader.error());
  Layout layout;
  LogTypes types;
  bool unknown = false;
  while (const auto event = reader->Next()) {
    types.See(*event);
    if (event->channel != channel) continue;
    const comms::LcmType* type = types.TypeOf(event->data);
    unknown |= type == nullptr;
    if (type == nullptr || (layout.messages > 0 && type->fingerprint() != layout.fingerprint))
      continue;
    layout.columns.Start();
    if (!type->Visit(event->data, layout.columns)) continue;
    ++layout.messages;
    layout.type_name = type->name();
    layout.fingerprint = type->fingerprint();
    if (!HasVariableColumns(*type)) break;  // all its messages look alike
  }
  if (layout.messages > 0) return layout;
  return core::Fail(
      core::ErrorCode::kNotFound,
      unknown ? "channel '" + channel +
                    "': the type of its messages is neither in the log's CONFIG nor known here"
              : "no messages on channel '" + channel + "' (kawara-log info lists the channels)");
}

}  // namespace

core::Expected<int> LogExport(const std::vector<std::string>& paths, const ExportOptions& options) {
  const auto layout = FindLayout(paths, options.channel);
  if (!layout) return tl::unexpected(layout.error());
  const bool pictures = layout->type_name == "phase1_t" || layout->type_name == "frame_t";
  if (!options.pictures.empty()) {
    if (!pictures) {
      return core::Fail(core::ErrorCode::kInvalidArgument, "--pictures: there are none in " +
                                                               layout->type_name + " on channel '" +
                                                               options.channel + "'");
    }
    std::error_code error;
    std::filesystem::create_directories(options.pictures, error);
    if (error)
      return tl::unexpected(core::ErrnoError("create folder " + options.pictures, error.value()));
  }
  auto reader = OpenLogs(paths);
  if (!reader) return tl::unexpected(reader.error());
  auto out = OutputFile::Open(options.out);
  if (!out) return tl::unexpected(out.error());

  std::string line = "event_number,recorded_utc";
  for (const std::string& name : layout->columns.names()) line += ',' + name;
  line += "\r\n";
  Row row(layout->columns.names());
  LogTypes types;
  std::uint64_t rows = 0;
  std::uint64_t skipped = 0;
  std::set<std::string> names;
  Progress progress(*reader);
  while (const auto event = reader->Next()) {
    progress.Tick();
    types.See(*event);
    if (event->channel != options.channel) continue;
    const comms::LcmType* type = types.TypeOf(event->data);
    if (type == nullptr || type->fingerprint() != layout->fingerprint ||
        !type->Check(event->data)) {
      ++skipped;
      continue;
    }
    row.Start(pictures);
    std::optional<Picture> picture;
    if (!options.pictures.empty()) picture = PictureIn(event->data);
    if (picture) {
      if (!names.insert(picture->name).second) {
        picture->name = "event" + std::to_string(event->number) + "-" + picture->name;
      }
      auto file =
          OutputFile::Open((std::filesystem::path(options.pictures) / picture->name).string());
      if (!file) return tl::unexpected(file.error());
      auto ok = file->Write(picture->header.data(), picture->header.size());
      if (ok) ok = file->Write(picture->bytes.data(), picture->bytes.size());
      if (ok) ok = file->Close();
      if (!ok) return tl::unexpected(ok.error());
    }
    row.SetPicture(picture ? picture->name : std::string());
    (void)type->Visit(event->data, row);
    line += std::to_string(event->number) + ',' + FormatTime(event->time_utc_us);
    row.AppendTo(line);
    if (auto ok = out->Write(line.data(), line.size()); !ok) return tl::unexpected(ok.error());
    line.clear();
    ++rows;
  }
  if (auto ok = out->Close(); !ok) return tl::unexpected(ok.error());
  std::fprintf(stderr, "%s: %llu rows of %s, %zu pictures\n", options.out.c_str(),
               static_cast<unsigned long long>(rows), layout->type_name.c_str(), names.size());
  if (skipped > 0) {
    std::fprintf(stderr, "%llu messages on '%s' are no %s: left out\n",
                 static_cast<unsigned long long>(skipped), options.channel.c_str(),
                 layout->type_name.c_str());
  }
  PrintDamage(stderr, reader->stats(), 10);
  return 0;
}

}  // namespace kawara::tools
