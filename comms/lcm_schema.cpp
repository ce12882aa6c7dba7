#include "comms/lcm_schema.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <set>

#include "comms/codec.hpp"
#include "core/check.hpp"

namespace kawara::comms {

// Text of comms/lcmtypes/*.lcm, written by CMake.
extern const char* const kLcmTypesText;

namespace {

// A log's CONFIG is data from outside: no text makes us loop, recurse or allocate beyond these.
constexpr std::size_t kMaxTextBytes = 1 << 20;
constexpr std::size_t kMaxMembers = 512;
constexpr std::size_t kMaxDimensions = 4;
constexpr int kMaxCountSlots = 16;
constexpr int kMaxDepth = 16;
constexpr std::uint64_t kMaxMessageBytes = std::numeric_limits<std::int32_t>::max();

struct Primitive {
  std::string_view name;
  LcmKind kind;
  std::uint64_t min_bytes;
};
constexpr std::array kPrimitives{
    Primitive{"int8_t", LcmKind::kInt8, 1},   Primitive{"int16_t", LcmKind::kInt16, 2},
    Primitive{"int32_t", LcmKind::kInt32, 4}, Primitive{"int64_t", LcmKind::kInt64, 8},
    Primitive{"byte", LcmKind::kByte, 1},     Primitive{"boolean", LcmKind::kBoolean, 1},
    Primitive{"float", LcmKind::kFloat, 4},   Primitive{"double", LcmKind::kDouble, 8},
    Primitive{"string", LcmKind::kString, 5},
};
const Primitive* FindPrimitive(std::string_view name) {
  const auto* it = std::ranges::find(kPrimitives, name, &Primitive::name);
  return it == kPrimitives.end() ? nullptr : it;
}

bool IsInteger(LcmKind kind) {
  return kind == LcmKind::kInt8 || kind == LcmKind::kInt16 || kind == LcmKind::kInt32 ||
         kind == LcmKind::kInt64;
}

std::uint64_t SaturatingMul(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}
std::uint64_t SaturatingAdd(std::uint64_t a, std::uint64_t b) {
  std::uint64_t sum = 0;
  return __builtin_add_overflow(a, b, &sum) ? UINT64_MAX : sum;
}

// lcm-gen's fingerprint (lcmgen.c, lcm_struct_hash): signed 64-bit arithmetic that wraps.
void HashByte(std::uint64_t& hash, std::uint8_t c) {
  const auto shifted_in = static_cast<std::uint64_t>(static_cast<std::int64_t>(hash) >> 55);
  hash = ((hash << 8) ^ shifted_in) + static_cast<std::uint64_t>(static_cast<std::int8_t>(c));
}
void HashText(std::uint64_t& hash, std::string_view text) {
  HashByte(hash, static_cast<std::uint8_t>(text.size()));
  for (char c : text) HashByte(hash, static_cast<std::uint8_t>(c));
}

}  // namespace

/// Recursive descent over the .lcm language; every problem ends in Fail with its line.
class LcmSchemaParser {
 public:
  explicit LcmSchemaParser(std::string_view text) : text_(text) {}

  core::Expected<LcmSchema> Parse() {
    if (text_.size() > kMaxTextBytes) return Error("over 1 MiB of text");
    Advance();
    while (!token_.empty() && !failed_) {
      if (Take("package")) {
        package_ = Name();
        Expect(";");
      } else if (Take("struct")) {
        ParseStruct();
      } else {
        Problem("expected package or struct");
      }
    }
    if (!failed_) Resolve();
    if (failed_) return Error(problem_);
    return std::move(schema_);
  }

 private:
  tl::unexpected<core::Error> Error(const std::string& what) const {
    return core::Fail(core::ErrorCode::kFormat,
                      "LCM types, line " + std::to_string(problem_line_) + ": " + what);
  }
  void Problem(const std::string& what) {
    if (failed_) return;
    failed_ = true;
    problem_ = what;
    problem_line_ = line_;
    token_ = {};
  }

  void SkipSpaceAndComments() {
    while (position_ < text_.size()) {
      const std::string_view rest = text_.substr(position_);
      if (std::isspace(static_cast<unsigned char>(rest[0])) != 0) {
        line_ += rest[0] == '\n';
        ++position_;
      } else if (rest.starts_with("//") || rest[0] == '#') {
        position_ += std::min(rest.find('\n'), rest.size());
      } else if (rest.starts_with("/*")) {
        const std::size_t end = std::min(rest.find("*/", 2), rest.size() - 2) + 2;
        line_ += static_cast<int>(std::ranges::count(rest.substr(0, end), '\n'));
        position_ += end;
      } else {
        return;
      }
    }
  }
  void Advance() {
    if (failed_) return;
    SkipSpaceAndComments();
    std::size_t end = position_;
    const auto word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
             c == '+';
    };
    while (end < text_.size() && word(text_[end])) ++end;
    if (end == position_ && end < text_.size()) ++end;
    token_ = text_.substr(position_, end - position_);
    position_ = end;
  }
  bool Take(std::string_view expected) {
    if (token_ != expected || failed_) return false;
    Advance();
    return true;
  }
  void Expect(std::string_view expected) {
    if (!Take(expected)) Problem("expected '" + std::string(expected) + "'");
  }
  std::string Name() {
    const bool good =
        !token_.empty() && token_.size() <= 255 &&
        (std::isalpha(static_cast<unsigned char>(token_[0])) != 0 || token_[0] == '_');
    if (!good) {
      Problem("expected a name");
      return {};
    }
    std::string name(token_);
    Advance();
    return name;
  }

  void ParseStruct() {
    auto type = std::make_unique<LcmType>();
    type->name_ = Name();
    type->package_ = package_;
    const bool taken = std::ranges::any_of(schema_.types_, [&](const auto& other) {
      return other->name_ == type->name_ && other->package_ == type->package_;
    });
    if (taken) return Problem("struct " + type->name_ + " a second time");
    Expect("{");
    while (!Take("}") && !failed_) {
      if (Take("const")) {
        while (!token_.empty() && token_ != ";") Advance();
        Expect(";");
      } else {
        ParseMembers(*type);
      }
    }
    Take(";");
    if (type->members_.empty()) return Problem("struct " + type->name_ + " has no members");
    schema_.types_.push_back(std::move(type));
  }

  void ParseMembers(LcmType& type) {
    const std::string type_name = Name();
    do {
      LcmType::Member member;
      member.type_name = type_name;
      member.name = Name();
      const Primitive* primitive = FindPrimitive(type_name);
      member.kind = primitive != nullptr ? primitive->kind : LcmKind::kStruct;
      while (Take("[")) {
        ParseDimension(type, member);
        Expect("]");
      }
      if (failed_) return;
      if (type.members_.size() >= kMaxMembers) return Problem("too many members");
      type.members_.push_back(std::move(member));
    } while (Take(","));
    Expect(";");
  }

  void ParseDimension(LcmType& type, LcmType::Member& member) {
    if (member.dimensions.size() >= kMaxDimensions) return Problem("too many dimensions");
    LcmType::Dimension dimension;
    dimension.text = std::string(token_);
    const auto [end, error] =
        std::from_chars(token_.data(), token_.data() + token_.size(), dimension.fixed);
    if (error == std::errc() && end == token_.data() + token_.size() && dimension.fixed > 0) {
      Advance();
    } else {
      const auto counter = std::ranges::find(type.members_, token_, &LcmType::Member::name);
      if (counter == type.members_.end() || !IsInteger(counter->kind) ||
          !counter->dimensions.empty()) {
        return Problem("array size is neither a positive number nor an integer member before it");
      }
      if (counter->count_slot < 0) {
        counter->count_slot = static_cast<int>(std::ranges::count_if(
            type.members_, [](const auto& other) { return other.count_slot >= 0; }));
      }
      if (counter->count_slot >= kMaxCountSlots) return Problem("too many array sizes");
      dimension.count_slot = counter->count_slot;
      Advance();
    }
    member.dimensions.push_back(std::move(dimension));
  }

  const LcmType* FindStruct(const LcmType& user, std::string_view name) const {
    for (const auto& type : schema_.types_) {
      const bool same_package = type->package_ == user.package_ && type->name_ == name;
      if (same_package || type->package_ + "." + type->name_ == name) return type.get();
    }
    return nullptr;
  }

  void Resolve() {
    for (auto& type : schema_.types_) ResolveType(*type, 0);
    for (auto& type : schema_.types_)
      schema_.by_fingerprint_.emplace(type->fingerprint_, type.get());
  }

  // Depth first: sizes and hashes of the structs inside come before those of the struct around
  // them.
  void ResolveType(LcmType& type, int depth) {
    if (failed_ || resolved_.contains(&type)) return;
    if (depth > kMaxDepth)
      return Problem("struct " + type.name_ + " is nested too deep or in itself");
    std::uint64_t children = 0;
    std::uint64_t hash = 0x12345678;
    for (LcmType::Member& member : type.members_) {
      HashText(hash, member.name);
      const Primitive* primitive = FindPrimitive(member.type_name);
      std::uint64_t bytes = 0;
      if (primitive != nullptr) {
        HashText(hash, member.type_name);
        bytes = primitive->min_bytes;
        type.fixed_size_ &= member.kind != LcmKind::kString;
      } else {
        member.struct_type = FindStruct(type, member.type_name);
        if (member.struct_type == nullptr) return Problem("no struct " + member.type_name);
        ResolveType(const_cast<LcmType&>(*member.struct_type), depth + 1);
        if (failed_) return;
        children += member.struct_type->hash_;
        bytes = member.struct_type->min_bytes_;
        type.fixed_size_ &= member.struct_type->fixed_size_;
      }
      HashByte(hash, static_cast<std::uint8_t>(member.dimensions.size()));
      for (const LcmType::Dimension& dimension : member.dimensions) {
        const bool variable = dimension.count_slot >= 0;
        HashByte(hash, variable ? 1 : 0);
        HashText(hash, dimension.text);
        type.fixed_size_ &= !variable;
        bytes = variable ? 0 : SaturatingMul(bytes, static_cast<std::uint64_t>(dimension.fixed));
      }
      type.min_bytes_ = SaturatingAdd(type.min_bytes_, bytes);
    }
    if (type.min_bytes_ > kMaxMessageBytes)
      return Problem("struct " + type.name_ + " is over 2 GiB");
    hash += children;
    type.hash_ = (hash << 1) + ((hash >> 63) & 1);
    type.fingerprint_ = static_cast<std::int64_t>(type.hash_);
    resolved_.insert(&type);
  }

  std::string_view text_;
  std::size_t position_ = 0;
  std::string_view token_;
  int line_ = 1;
  std::string package_;
  LcmSchema schema_;
  std::set<const LcmType*> resolved_;
  bool failed_ = false;
  std::string problem_;
  int problem_line_ = 0;
};

core::Expected<LcmSchema> LcmSchema::Parse(std::string_view text) {
  return LcmSchemaParser(text).Parse();
}

std::string_view LcmSchema::BuiltinText() { return kLcmTypesText; }
std::string_view LcmTypesText() { return LcmSchema::BuiltinText(); }

const LcmSchema& LcmSchema::Builtin() {
  static const LcmSchema schema = [] {
    auto parsed = Parse(BuiltinText());
    CORE_CHECK(parsed.has_value());
    return std::move(*parsed);
  }();
  return schema;
}

const LcmType* LcmSchema::Find(std::string_view name) const {
  for (const auto& type : types_) {
    if (type->name() == name || type->package() + "." + type->name() == name) return type.get();
  }
  return nullptr;
}

const LcmType* LcmSchema::FindByFingerprint(std::int64_t fingerprint) const {
  const auto it = by_fingerprint_.find(fingerprint);
  return it == by_fingerprint_.end() ? nullptr : it->second;
}

const LcmType* LcmSchema::TypeOf(std::span<const std::uint8_t> message) const {
  if (message.size() < 8) return nullptr;
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < 8; ++i) fingerprint = fingerprint << 8 | message[i];
  return FindByFingerprint(static_cast<std::int64_t>(fingerprint));
}

const LcmType& internal::BuiltinType(const char* name, std::int64_t fingerprint) {
  const LcmType* type = LcmSchema::Builtin().FindByFingerprint(fingerprint);
  CORE_CHECK(type != nullptr && type->name() == name);
  return *type;
}

}  // namespace kawara::comms
