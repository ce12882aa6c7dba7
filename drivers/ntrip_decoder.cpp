#include "drivers/ntrip_decoder.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace kawara::drivers {
namespace {

constexpr std::size_t kMaxLine = 1024;
constexpr std::size_t kMaxSources = 4096;

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}
std::string_view Trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}
bool IsTableLine(std::string_view line) {
  return line.starts_with("STR;") || line.starts_with("CAS;") || line.starts_with("NET;") ||
         line.starts_with("ENDSOURCETABLE");
}

}  // namespace

std::optional<std::span<const std::uint8_t>> NtripDecoder::Next(
    std::span<const std::uint8_t>& bytes) {
  while (!bytes.empty()) {
    switch (phase_) {
      case Phase::kStatus:
        if (TakeLine(bytes)) OnStatusLine();
        break;
      case Phase::kHeaders:
        if (TakeLine(bytes)) OnHeader();
        break;
      case Phase::kAfterIcy:
        if (AfterIcy(bytes) && !released_.empty()) {
          payload_bytes_ += released_.size();
          return std::span(reinterpret_cast<const std::uint8_t*>(released_.data()),
                           released_.size());
        }
        break;
      case Phase::kBody: {
        const auto take =
            static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), body_left_));
        const auto body = bytes.first(take);
        bytes = bytes.subspan(take);
        if (body_left_ != UINT64_MAX) body_left_ -= take;
        const auto payload = Body(body);
        if (body_left_ == 0) OnClosed();
        if (payload) return payload;
        break;
      }
      case Phase::kChunkSize:
        if (TakeLine(bytes)) OnChunkSize();
        break;
      case Phase::kChunkData: {
        const auto take =
            static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), chunk_left_));
        const auto body = bytes.first(take);
        bytes = bytes.subspan(take);
        chunk_left_ -= take;
        if (chunk_left_ == 0) phase_ = Phase::kChunkEnd;
        if (const auto payload = Body(body)) return payload;
        break;
      }
      case Phase::kChunkEnd: {
        const std::uint8_t byte = bytes.front();
        bytes = bytes.subspan(1);
        if (byte == '\n') {
          phase_ = Phase::kChunkSize;
        } else if (byte != '\r') {
          Fail(NtripFailure::kBrokenChunk);
        }
        break;
      }
      case Phase::kTrailer:
        if (TakeLine(bytes)) {
          const bool blank = line_.empty();
          line_.clear();
          if (blank) OnClosed();
        }
        break;
      case Phase::kOver:
        bytes = {};
        break;
    }
  }
  return std::nullopt;
}

void NtripDecoder::OnClosed() {
  if (state_ == NtripState::kDone) return;
  if (phase_ == Phase::kStatus && !line_.empty())
    OnStatusLine();  // a refusal without an end of line
  if (state_ == NtripState::kDone) return;
  if (state_ == NtripState::kSourcetable) {
    OnTableLine();
    if (state_ == NtripState::kDone) return;
    Fail(wants_table_ ? NtripFailure::kNone : NtripFailure::kWrongMountpoint);
    return;
  }
  Fail(NtripFailure::kEnded);
}

std::optional<std::span<const std::uint8_t>> NtripDecoder::Body(
    std::span<const std::uint8_t> body) {
  if (state_ == NtripState::kStreaming) {
    payload_bytes_ += body.size();
    if (!body.empty()) return body;
    return std::nullopt;
  }
  for (const std::uint8_t byte : body) {
    if (byte == '\n') {
      OnTableLine();
      if (state_ == NtripState::kDone) break;
    } else if (byte != '\r' && table_line_.size() < kMaxLine) {
      table_line_ += static_cast<char>(byte);
    }
  }
  return std::nullopt;
}

/// True when line_ holds a whole line, without its CR LF.
bool NtripDecoder::TakeLine(std::span<const std::uint8_t>& bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), std::uint8_t{'\n'});
  const auto count = static_cast<std::size_t>(end - bytes.begin());
  const std::size_t room = kMaxLine - std::min(kMaxLine, line_.size());
  if (count > room) line_too_long_ = true;
  line_.append(reinterpret_cast<const char*>(bytes.data()), std::min(count, room));
  const bool complete = end != bytes.end();
  bytes = bytes.subspan(count + (complete ? 1 : 0));
  if (line_too_long_ && phase_ != Phase::kHeaders && phase_ != Phase::kTrailer) {
    // A status or chunk size has no business being this long: stop before it costs more.
    if (phase_ == Phase::kStatus) status_line_ = line_.substr(0, 80);
    Fail(phase_ == Phase::kStatus ? NtripFailure::kNotNtrip : NtripFailure::kBrokenChunk);
    return false;
  }
  if (complete) {
    line_too_long_ = false;
    if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  }
  return complete;
}

void NtripDecoder::OnStatusLine() {
  if (line_.empty()) return;  // a blank line before the status
  if (line_.back() == '\r') line_.pop_back();
  status_line_ = line_;
  line_.clear();
  const std::string_view s = status_line_;
  if (s.starts_with("ICY 200")) {
    version_ = 1;
    state_ = NtripState::kStreaming;
    phase_ = Phase::kAfterIcy;
  } else if (s.starts_with("SOURCETABLE 200")) {
    version_ = 1;
    is_table_ = true;
    phase_ = Phase::kHeaders;
  } else if (s.starts_with("HTTP/1.") && s.size() >= 12) {
    version_ = 2;
    std::from_chars(s.data() + 9, s.data() + 12, http_code_);
    phase_ = Phase::kHeaders;
  } else if (s.starts_with("ERROR") || s.starts_with("ICY ")) {
    version_ = 1;
    const std::string lower = Lower(s);
    if (lower.find("password") != std::string::npos || lower.find("401") != std::string::npos ||
        lower.find("unauthor") != std::string::npos) {
      Fail(NtripFailure::kWrongPassword);
    } else if (lower.find("mount") != std::string::npos || lower.find("404") != std::string::npos) {
      Fail(NtripFailure::kWrongMountpoint);
    } else {
      Fail(NtripFailure::kServerError);
    }
  } else {
    status_line_.resize(std::min<std::size_t>(status_line_.size(), 80));
    Fail(NtripFailure::kNotNtrip);
  }
}

/// After "ICY 200 OK" come corrections, at once, or after a blank line, or (some casters) after
/// headers and a blank line. Text that still may be a header is held back; what turns out not to be
/// one is payload. True when the question is settled.
bool NtripDecoder::AfterIcy(std::span<const std::uint8_t>& bytes) {
  while (!bytes.empty()) {
    const auto c = static_cast<char>(bytes.front());
    const auto u = bytes.front();
    bytes = bytes.subspan(1);
    released_ += c;
    const bool in_value = line_.find(':') != std::string::npos;
    if (c == '\n' && (line_.empty() || line_ == "\r")) {
      released_.clear();
      Stream();
      return true;
    }
    bool plausible = false;
    if (c == '\n') {
      plausible = in_value;
    } else if (line_.empty()) {
      plausible = std::isalpha(u) != 0 || c == '\r';
    } else if (in_value) {
      plausible = (u >= 0x20 && u < 0x7F) || c == '\t' || c == '\r';
    } else {
      plausible = line_ != "\r" && (std::isalnum(u) != 0 || c == '-' || c == ':');
    }
    if (!plausible || released_.size() > kMaxLine) {
      Stream();
      return true;
    }
    if (c == '\n') {
      line_.clear();
    } else {
      line_ += c;
    }
  }
  return false;
}

void NtripDecoder::OnHeader() {
  if (line_.empty()) return OnHeadersDone();
  if (is_table_ && IsTableLine(line_)) {  // a table without a blank line before it
    OnHeadersDone();
    table_line_ = line_;
    line_.clear();
    return OnTableLine();
  }
  const std::size_t colon = line_.find(':');
  if (colon != std::string::npos) {
    const std::string name = Lower(Trim(std::string_view(line_).substr(0, colon)));
    const std::string_view raw = Trim(std::string_view(line_).substr(colon + 1));
    const std::string value = Lower(raw);
    if (name == "transfer-encoding") {
      chunked_ = value.find("chunked") != std::string::npos;
      if (value.find("gzip") != std::string::npos || value.find("deflate") != std::string::npos)
        encoding_ = value;
    } else if (name == "content-encoding" && value != "identity") {
      encoding_ = value;
    } else if (name == "content-type") {
      if (value.starts_with("gnss/sourcetable") || value.starts_with("text/plain"))
        is_table_ = true;
      is_web_page_ = value.starts_with("text/html");
    } else if (name == "content-length") {
      std::uint64_t length = 0;
      if (std::from_chars(value.data(), value.data() + value.size(), length).ec == std::errc{})
        body_left_ = length;
    } else if (name == "www-authenticate") {
      digest_ = value.starts_with("digest");
    } else if (name == "location") {
      location_ = raw;
    }
  }
  line_.clear();
}

void NtripDecoder::OnHeadersDone() {
  if (version_ == 2 && http_code_ != 200) {
    if (http_code_ == 401 || http_code_ == 403) return Fail(NtripFailure::kWrongPassword);
    if (http_code_ == 404) return Fail(NtripFailure::kWrongMountpoint);
    if (http_code_ == 409) return Fail(NtripFailure::kMountpointInUse);
    if (http_code_ >= 300 && http_code_ < 400) return Fail(NtripFailure::kRedirected);
    return Fail(NtripFailure::kServerError);
  }
  if (!encoding_.empty()) return Fail(NtripFailure::kEncoding);
  if (is_web_page_) return Fail(NtripFailure::kNotNtrip);
  state_ = is_table_ ? NtripState::kSourcetable : NtripState::kStreaming;
  if (chunked_) body_left_ = UINT64_MAX;
  phase_ = chunked_ ? Phase::kChunkSize : Phase::kBody;
  if (body_left_ == 0) OnClosed();
}

void NtripDecoder::OnTableLine() {
  if (table_line_.starts_with("ENDSOURCETABLE")) {
    table_line_.clear();
    return Fail(wants_table_ ? NtripFailure::kNone : NtripFailure::kWrongMountpoint);
  }
  if (sources_.size() < kMaxSources) {
    if (auto source = ParseNtripSource(table_line_)) sources_.push_back(std::move(*source));
  }
  table_line_.clear();
}

void NtripDecoder::OnChunkSize() {
  constexpr std::uint64_t kMaxChunk = std::uint64_t{1} << 24;
  const std::string_view text = Trim(std::string_view(line_).substr(0, line_.find(';')));
  std::uint64_t size = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), size, 16);
  const bool good =
      !text.empty() && result.ec == std::errc{} && result.ptr == text.data() + text.size();
  line_.clear();
  if (!good || size > kMaxChunk) return Fail(NtripFailure::kBrokenChunk);
  if (size == 0) {
    phase_ = Phase::kTrailer;
    return;
  }
  ++chunks_;
  chunk_left_ = size;
  phase_ = Phase::kChunkData;
}

void NtripDecoder::Stream() {
  line_.clear();
  phase_ = Phase::kBody;
}

/// The answer is over, with or without a failure.
void NtripDecoder::Fail(NtripFailure failure) {
  failure_ = failure;
  state_ = NtripState::kDone;
  phase_ = Phase::kOver;
}

core::Error NtripDecoder::Explain(const NtripRequest& r) const {
  using core::ErrorCode;
  const std::string who = "ntrip " + r.host + ":" + std::to_string(r.port) + ": ";
  const std::string said = status_line_.empty() ? "" : " (it said: " + status_line_ + ")";
  switch (failure_) {
    case NtripFailure::kNone:
      break;
    case NtripFailure::kWrongPassword:
      if (digest_) {
        return {ErrorCode::kPermission,
                who + "wants Digest authentication, only Basic is supported" + said};
      }
      if (r.user.empty())
        return {ErrorCode::kPermission,
                who + "wants a user and password for " + r.mountpoint + said};
      return {ErrorCode::kPermission,
              who + "user '" + r.user + "' or its password refused for " + r.mountpoint + said};
    case NtripFailure::kWrongMountpoint:
      return {ErrorCode::kNotFound,
              who + "no mountpoint '" + r.mountpoint + "'; " +
                  (sources_.empty() ? "it sent no list of others" + said
                                    : "it offers " + ListMountpoints(sources_, 120))};
    case NtripFailure::kMountpointInUse:
      return {ErrorCode::kUnavailable, who + "mountpoint " + r.mountpoint + " is in use" + said};
    case NtripFailure::kRedirected:
      return {ErrorCode::kNotFound,
              who + "has moved to " + (location_.empty() ? "somewhere else" : location_)};
    case NtripFailure::kServerError:
      return {ErrorCode::kUnavailable, who + "the caster can not serve " + r.mountpoint + said};
    case NtripFailure::kNotNtrip:
      return {ErrorCode::kFormat, who + "this is no NTRIP caster: check host and port" + said};
    case NtripFailure::kEncoding:
      return {ErrorCode::kFormat,
              who + "sends '" + encoding_ + "' encoded data, which is not supported"};
    case NtripFailure::kBrokenChunk:
      return {ErrorCode::kFormat, who + "chunked transfer is damaged; connecting anew"};
    case NtripFailure::kEnded:
      if (status_line_.empty())
        return {ErrorCode::kUnavailable, who + "closed the connection without an answer"};
      return {ErrorCode::kUnavailable, who + "closed the stream of " + r.mountpoint};
  }
  return {ErrorCode::kUnavailable, who + "no failure"};
}

}  // namespace kawara::drivers
