#include "tools/decode_common.hpp"

namespace kawara::tools {

int DecodeGps(ByteSource& source, JsonLines& out, const DecodeOptions&) {
  DecodeSummary summary;
  for (auto bytes = source.Read(); !bytes.empty(); bytes = source.Read())
    summary.skipped_bytes += bytes.size();
  summary.comment_bytes = source.comment_bytes();
  WriteSummary(out, summary);
  return 0;
}

}  // namespace kawara::tools
