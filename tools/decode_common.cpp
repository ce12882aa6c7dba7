#include "tools/decode_common.hpp"

namespace kawara::tools {

void WriteSummary(JsonLines& out, const DecodeSummary& summary,
                  const std::function<void(JsonLines&)>& more) {
  out.BeginBare();
  out.OpenObject("summary");
  out.Unsigned("good", summary.good);
  out.Unsigned("bad_checksum", summary.bad_checksum);
  out.Unsigned("skipped_bytes", summary.skipped_bytes);
  summary.types.Write(out, "types");
  out.Unsigned("good_bytes", summary.good_bytes);
  out.Unsigned("bad_bytes", summary.bad_bytes);
  out.Unsigned("comment_bytes", summary.comment_bytes);
  out.Unsigned("total_bytes", summary.good_bytes + summary.bad_bytes + summary.skipped_bytes +
                                  summary.comment_bytes);
  if (more) more(out);
  out.CloseObject();
  out.End();
}

}  // namespace kawara::tools
