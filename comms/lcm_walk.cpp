#include <array>
#include <bit>
#include <cstring>

#include "comms/lcm_schema.hpp"
#include "core/check.hpp"

namespace kawara::comms {
namespace {

std::size_t ScalarBytes(LcmKind kind) {
  switch (kind) {
    case LcmKind::kInt16:
      return 2;
    case LcmKind::kInt32:
    case LcmKind::kFloat:
      return 4;
    case LcmKind::kInt64:
    case LcmKind::kDouble:
      return 8;
    default:
      return 1;
  }
}

}  // namespace

/// Goes through a message along its type. Without a visitor it only checks. Every element consumes
/// at least one byte of the message, and array sizes are held against the bytes that are left
/// before the elements are looked at: the time is bounded by the message's length whatever it
/// claims.
class LcmWalker {
 public:
  LcmWalker(std::span<const std::uint8_t> message, LcmVisitor* visitor)
      : rest_(message), visitor_(visitor) {}

  bool Struct(const LcmType& type) {
    if (visitor_ == nullptr && type.fixed_size_) return Skip(type.min_bytes_);
    std::array<std::int64_t, 16> counts{};
    for (const LcmType::Member& member : type.members_) {
      const std::size_t length = path_.size();
      if (visitor_ != nullptr) {
        if (!path_.empty()) path_ += '.';
        path_ += member.name;
      }
      std::array<std::uint64_t, 4> sizes{};
      std::uint64_t elements = 1;
      for (std::size_t d = 0; d < member.dimensions.size(); ++d) {
        const LcmType::Dimension& dimension = member.dimensions[d];
        const std::int64_t size = dimension.count_slot >= 0
                                      ? counts[static_cast<std::size_t>(dimension.count_slot)]
                                      : dimension.fixed;
        if (size < 0) return false;
        sizes[d] = static_cast<std::uint64_t>(size);
        if (elements == 0) continue;  // an outer size is 0: nothing of this one will be there
        if (sizes[d] > rest_.size()) return false;
        elements *= sizes[d];  // neither factor exceeds a message's size (< 2^31): no overflow
        if (elements > rest_.size()) return false;
      }
      if (!Array(member, sizes, 0, counts)) return false;
      path_.resize(length);
    }
    return true;
  }

  bool AtEnd() const { return rest_.empty(); }

 private:
  using Sizes = std::array<std::uint64_t, 4>;
  using Counts = std::array<std::int64_t, 16>;

  bool Skip(std::uint64_t n) {
    if (n > rest_.size()) return false;
    rest_ = rest_.subspan(static_cast<std::size_t>(n));
    return true;
  }

  bool Array(const LcmType::Member& member, const Sizes& sizes, std::size_t dimension,
             Counts& counts) {
    if (dimension == member.dimensions.size()) return Element(member, counts);
    const std::uint64_t size = sizes[dimension];
    const bool innermost = dimension + 1 == member.dimensions.size();
    const bool scalar = member.kind != LcmKind::kStruct && member.kind != LcmKind::kString;
    if (innermost && scalar && visitor_ == nullptr) return Skip(size * ScalarBytes(member.kind));
    if (innermost && member.kind == LcmKind::kByte) {
      if (size > rest_.size()) return false;
      visitor_->Bytes(path_, rest_.first(static_cast<std::size_t>(size)));
      return Skip(size);
    }
    const std::size_t length = path_.size();
    for (std::uint64_t i = 0; i < size; ++i) {
      if (visitor_ != nullptr) path_ += '[' + std::to_string(i) + ']';
      if (!Array(member, sizes, dimension + 1, counts)) return false;
      path_.resize(length);
    }
    return true;
  }

  bool Element(const LcmType::Member& member, Counts& counts) {
    if (member.kind == LcmKind::kStruct) return Struct(*member.struct_type);
    if (member.kind == LcmKind::kString) return String();
    const std::size_t bytes = ScalarBytes(member.kind);
    if (bytes > rest_.size()) return false;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < bytes; ++i) bits = bits << 8 | rest_[i];
    rest_ = rest_.subspan(bytes);
    const std::int64_t value = SignExtended(bits, bytes);
    if (member.count_slot >= 0) counts[static_cast<std::size_t>(member.count_slot)] = value;
    if (visitor_ == nullptr) return true;
    if (member.kind == LcmKind::kDouble) {
      visitor_->Real(path_, std::bit_cast<double>(bits));
    } else if (member.kind == LcmKind::kFloat) {
      visitor_->Real(path_,
                     static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
    } else {
      visitor_->Integer(path_, member.kind,
                        member.kind == LcmKind::kByte ? static_cast<std::int64_t>(bits) : value);
    }
    return true;
  }

  static std::int64_t SignExtended(std::uint64_t bits, std::size_t bytes) {
    CORE_CHECK(bytes >= 1 && bytes <= 8);
    const unsigned shift = 64U - 8U * static_cast<unsigned>(bytes);
    return static_cast<std::int64_t>(bits << shift) >> shift;
  }

  // int32 length with the NUL that ends it. A text with a NUL inside is not one lcm_encode could
  // have written.
  bool String() {
    if (rest_.size() < 4) return false;
    std::uint32_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | rest_[i];
    rest_ = rest_.subspan(4);
    if (length < 1 || length > rest_.size()) return false;
    const void* nul = std::memchr(rest_.data(), 0, length);
    if (nul != rest_.data() + length - 1) return false;
    if (visitor_ != nullptr) {
      const auto text = rest_.first(length - 1);
      visitor_->Text(path_, {reinterpret_cast<const char*>(text.data()), text.size()});
    }
    rest_ = rest_.subspan(length);
    return true;
  }

  std::span<const std::uint8_t> rest_;
  LcmVisitor* visitor_;
  std::string path_;
};

core::Expected<void> LcmType::Check(std::span<const std::uint8_t> message) const {
  constexpr std::size_t kLimit = 0x7fffffff;
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < 8 && i < message.size(); ++i)
    fingerprint = fingerprint << 8 | message[i];
  if (message.size() < 8 || message.size() > kLimit ||
      static_cast<std::int64_t>(fingerprint) != fingerprint_) {
    return core::Fail(
        core::ErrorCode::kFormat,
        std::to_string(message.size()) + " bytes that are no " + name_ + " of this version");
  }
  LcmWalker walker(message.subspan(8), nullptr);
  if (!walker.Struct(*this) || !walker.AtEnd()) {
    return core::Fail(core::ErrorCode::kFormat, name_ + " of " + std::to_string(message.size()) +
                                                    " bytes: its counts do not fit its length");
  }
  return {};
}

core::Expected<void> LcmType::Visit(std::span<const std::uint8_t> message,
                                    LcmVisitor& visitor) const {
  if (auto ok = Check(message); !ok) return ok;
  LcmWalker walker(message.subspan(8), &visitor);
  (void)walker.Struct(*this);  // Check went the same way
  return {};
}

}  // namespace kawara::comms
