#pragma once
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace kawara::tools {

/// Writes one JSON object a line to a C stream. The buffer of a line is reused, so memory stays
/// constant. Keys and structure are the caller's; strings are escaped (bytes that are not UTF-8
/// become \u00XX), a number that is not finite becomes null. One thread.
///   out.Begin("GPGGA"); out.Number("lat_deg", 35.1, 10); out.End();
class JsonLines {
 public:
  explicit JsonLines(std::FILE* stream) : stream_(stream) { line_.reserve(1024); }

  /// Starts a line that has "type" as its first member.
  void Begin(std::string_view type);
  /// Starts a line without members.
  void BeginBare();
  void End();

  /// `decimals` digits after the point at most; trailing zeros are left out.
  void Number(std::string_view key, double value, int decimals);
  void Integer(std::string_view key, std::int64_t value);
  void Unsigned(std::string_view key, std::uint64_t value);
  void Boolean(std::string_view key, bool value);
  void Text(std::string_view key, std::string_view value);
  void Null(std::string_view key);

  /// Members written until CloseObject()/CloseArray() go inside. In an array, pass an empty key.
  void OpenObject(std::string_view key);
  void CloseObject();
  void OpenArray(std::string_view key);
  void CloseArray();

  /// False once the stream could not take a line (disk full, closed pipe).
  bool ok() const { return ok_; }
  /// Everything to the system; false if something was lost.
  bool Flush();

 private:
  void Key(std::string_view key);
  void Quoted(std::string_view text);

  std::FILE* stream_;
  std::string line_;
  bool first_ = true;
  bool ok_ = true;
};

}  // namespace kawara::tools
