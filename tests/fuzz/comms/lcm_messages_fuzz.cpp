#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "comms/codec.hpp"
#include "comms/message_types.hpp"

using namespace kawara::comms;

namespace {

class Counter : public LcmVisitor {
 public:
  void Integer(std::string_view path, LcmKind, std::int64_t) override { Count(path); }
  void Real(std::string_view path, double) override { Count(path); }
  void Text(std::string_view path, std::string_view) override { Count(path); }
  void Bytes(std::string_view path, std::span<const std::uint8_t>) override { Count(path); }
  std::size_t leaves = 0;

 private:
  void Count(std::string_view path) {
    if (path.empty()) std::abort();
    ++leaves;
  }
};

}  // namespace

// First byte: the type (its fingerprint is put before the rest), or the rest is the text of a
// schema. What decodes must encode to the same bytes again: then nothing was misread.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t types = LcmSchema::Builtin().types().size();
  const std::size_t selected = data[0] % (types + 1);
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  if (selected == types) {
    (void)LcmSchema::Parse({reinterpret_cast<const char*>(rest.data()), rest.size()});
    return 0;
  }
  std::size_t index = 0;
  ForEachMessageType([&]<class T>(std::type_identity<T>) {
    if (index++ != selected) return;
    std::vector<std::uint8_t> message(8);
    const auto fingerprint = static_cast<std::uint64_t>(T::getHash());
    for (unsigned i = 0; i < 8; ++i)
      message[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
    message.insert(message.end(), rest.begin(), rest.end());
    const auto decoded = Decode<T>(message);
    Counter counter;
    const bool visited = LcmSchema::Builtin().TypeOf(message)->Visit(message, counter).has_value();
    if (visited != decoded.has_value()) std::abort();
    if (decoded && Encode(*decoded) != message) std::abort();
  });
  return 0;
}
