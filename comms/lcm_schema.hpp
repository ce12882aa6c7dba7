#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"

namespace kawara::comms {

class LcmSchema;
class LcmType;

/// What a member of an LCM type is made of.
enum class LcmKind {
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kByte,
  kBoolean,
  kFloat,
  kDouble,
  kString,
  kStruct
};

/// Receives the leaves of a message in the order they stand in it. `path` is like
/// "pose.velocity_enu_mps[1]"; byte arrays come as one leaf. Spans and views are valid during the
/// call.
class LcmVisitor {
 public:
  virtual ~LcmVisitor() = default;
  virtual void Integer(std::string_view path, LcmKind kind, std::int64_t value) = 0;
  virtual void Real(std::string_view path, double value) = 0;
  virtual void Text(std::string_view path, std::string_view value) = 0;
  virtual void Bytes(std::string_view path, std::span<const std::uint8_t> value) = 0;
};

/// One message type: how its bytes lie. Source of the encoding: LCM documentation, "LCM Type
/// Specification Language" (big-endian, 8-byte fingerprint first, strings as int32 length including
/// NUL).
class LcmType {
 public:
  struct Dimension {
    std::int32_t fixed = 0;  ///< used if count_slot < 0
    int count_slot = -1;     ///< Member::count_slot of the integer that holds the count
    std::string text;        ///< as written: "3" or "n"
  };
  struct Member {
    std::string name;
    LcmKind kind = LcmKind::kInt8;
    std::string type_name;  ///< as written: "int64_t", "pose_t"
    const LcmType* struct_type = nullptr;
    std::vector<Dimension> dimensions;  ///< empty: scalar
    int count_slot = -1;                ///< >= 0: a later member's dimension
  };

  const std::string& name() const { return name_; }        ///< "pose_t", without package
  const std::string& package() const { return package_; }  ///< "kawara", may be empty
  std::int64_t fingerprint() const { return fingerprint_; }
  const std::vector<Member>& members() const { return members_; }

  /// True message of this type: right fingerprint, every count and string length fits, nothing is
  /// left over. Errors: kFormat. Never allocates except for the error.
  [[nodiscard]] core::Expected<void> Check(std::span<const std::uint8_t> message) const;
  /// Hands every leaf to the visitor. Same errors as Check, nothing is visited then.
  [[nodiscard]] core::Expected<void> Visit(std::span<const std::uint8_t> message,
                                           LcmVisitor& visitor) const;

 private:
  friend class LcmSchema;
  friend class LcmSchemaParser;
  friend class LcmWalker;
  std::string name_;
  std::string package_;
  std::int64_t fingerprint_ = 0;
  std::uint64_t hash_ =
      0;  ///< of the members' names and types, then with those of the structs in it
  std::uint64_t min_bytes_ = 0;  ///< of the shortest message, without fingerprint
  bool fixed_size_ = true;       ///< every message is min_bytes_ long
  std::vector<Member> members_;
};

/// A set of LCM types, read from their text. A log's CONFIG carries the text of the types it was
/// written with, so its messages can be read field by field long after the types in the program
/// have changed. Immutable after Parse; any thread.
class LcmSchema {
 public:
  /// All .lcm texts one after another. Takes package, struct, constants and comments; hostile text
  /// is refused, not obeyed (bounded sizes and nesting). Errors: kFormat with the line.
  [[nodiscard]] static core::Expected<LcmSchema> Parse(std::string_view text);
  /// The types of comms/lcmtypes this program was built with.
  static const LcmSchema& Builtin();
  /// Their text, for config_t.lcmtypes.
  static std::string_view BuiltinText();

  const LcmType* Find(std::string_view name) const;  ///< null: no such type
  const LcmType* FindByFingerprint(std::int64_t fingerprint) const;
  /// The type of a message by its first 8 bytes; null: unknown or too short.
  const LcmType* TypeOf(std::span<const std::uint8_t> message) const;
  const std::vector<std::unique_ptr<LcmType>>& types() const { return types_; }

 private:
  friend class LcmSchemaParser;
  std::vector<std::unique_ptr<LcmType>> types_;
  std::map<std::int64_t, const LcmType*> by_fingerprint_;
};

/// LcmSchema::BuiltinText().
std::string_view LcmTypesText();

}  // namespace kawara::comms
