#include "drivers/zxtreme_steps.hpp"

#include <array>

#include "drivers/ashtech.hpp"

namespace kawara::drivers {
namespace {

constexpr const char* kNoRtk = "no RTK without it: look at the options RID prints (J or K needed)";
constexpr const char* kNoFix = "no position from this receiver without it";
constexpr const char* kLess = "the set-up goes on without it";
constexpr const char* kNoAccuracy = "accuracy then comes from CBN or from a table";
constexpr const char* kNoShutter = "pictures then are dated by the computer's clock: option E or P";
constexpr auto kAck = ZXtremeReply::kAck;

constexpr std::array kSteps{
    ZXtremeStep{"PASHQ,RID", ZXtremeReply::kIdentity, "gps.setup.rid", "who it is stays unknown"},
    ZXtremeStep{"PASHQ,PRT", ZXtremeReply::kPort, "gps.setup.prt",
                "the configured port letter is used"},
    ZXtremeStep{"PASHS,NME,ALL,%d,OFF", kAck, "gps.setup.nme_off", "old sentences go on"},
    ZXtremeStep{"PASHS,OUT,%d", kAck, "gps.setup.out_off", "old raw data go on"},
    ZXtremeStep{"PASHS,RTC,REM,%r", kAck, "gps.setup.rtc_rem", kNoRtk},
    ZXtremeStep{"PASHS,SPD,%r,%b", kAck, "gps.setup.spd", "corrections may come at a wrong speed"},
    ZXtremeStep{"PASHS,CPD,MOD,ROV", kAck, "gps.setup.cpd_mod", kNoRtk},
    ZXtremeStep{"PASHS,CPD,FST,ON", kAck, "gps.setup.cpd_fst",
                "positions follow the base's rate, up to 2 s late"},
    ZXtremeStep{"PASHS,CPD,DYN,%y", kAck, "gps.setup.cpd_dyn", kLess},
    ZXtremeStep{"PASHS,NME,PER,%t", kAck, "gps.setup.nme_per",
                "below 1 s the receiver needs its 10 Hz option"},
    ZXtremeStep{"PASHS,RCI,%t", kAck, "gps.setup.rci",
                "below 1 s the receiver needs its 10 Hz option"},
    ZXtremeStep{"PASHS,NME,GGA,%d,ON", kAck, "gps.setup.gga", kNoFix},
    ZXtremeStep{"PASHS,NME,RMC,%d,ON", kAck, "gps.setup.rmc", "the date then comes from ZDA"},
    ZXtremeStep{"PASHS,NME,VTG,%d,ON", kAck, "gps.setup.vtg", kLess},
    ZXtremeStep{"PASHS,NME,GST,%d,ON", kAck, "gps.setup.gst", kNoAccuracy},
    ZXtremeStep{"PASHS,NME,ZDA,%d,ON", kAck, "gps.setup.zda", "the date then comes from RMC"},
    ZXtremeStep{"PASHS,NME,POS,%d,ON", kAck, "gps.setup.pos",
                "float and code solutions then look alike"},
    ZXtremeStep{"PASHS,OUT,%d,CBN", kAck, "gps.setup.cbn", "no covariance then"},
    ZXtremeStep{"PASHS,NME,LTN,%d,ON", kAck, "gps.setup.ltn", kLess},
    ZXtremeStep{"PASHS,NME,PTT,%d,ON", kAck, "gps.setup.ptt",
                "PPS pulses are then named by sentences"},
    ZXtremeStep{"PASHS,NME,TTT,%d,ON", kAck, "gps.setup.ttt", kNoShutter},
    ZXtremeStep{"PASHS,PPS,%p", kAck, "gps.setup.pps", "the receiver needs its PPS option"},
    ZXtremeStep{"PASHQ,PPS", ZXtremeReply::kPps, "gps.setup.pps_check",
                "whether PPS runs is unknown"},
    ZXtremeStep{"PASHS,PHE,%e", kAck, "gps.setup.phe", kNoShutter},
    ZXtremeStep{"PASHQ,PHE", ZXtremeReply::kEventEdge, "gps.setup.phe_check", kNoShutter},
    ZXtremeStep{"PASHS,SAV,%s", kAck, "gps.setup.sav", "the settings are lost at power-off"},
};

/// "0.1", "1", "+0.5": no more decimals than it needs.
void AppendNumber(ZXtremeCommand& out, double value, bool sign, int max_decimals) {
  if (sign && value >= 0.0) out.Append("+");
  core::FixedText<32> text;
  text.Append(value, max_decimals);
  std::string_view digits = text.view();
  if (digits.find('.') != std::string_view::npos) {
    while (digits.back() == '0') digits.remove_suffix(1);
    if (digits.back() == '.') digits.remove_suffix(1);
  }
  out.Append(digits);
}

/// False: this step is left out.
bool Expand(char placeholder, const ZXtremeConfig& c, char data_port, ZXtremeCommand& out) {
  switch (placeholder) {
    case 'd':
      out.Append(std::string_view(&data_port, 1));
      return true;
    case 'r':
      out.Append(std::string_view(&c.rtcm_port, 1));
      return true;
    case 'b':
      // Never the port we talk through: its speed is ours.
      if (c.rtcm_port == data_port || AshtechBaudCode(c.rtcm_baud_bps) < 0) return false;
      out.Append(AshtechBaudCode(c.rtcm_baud_bps));
      return true;
    case 't':
      AppendNumber(out, c.period_s, false, 1);
      return true;
    case 'y':
      out.Append(c.dynamics);
      return true;
    case 'p':
      AppendNumber(out, c.pps_period_s, false, 1);
      out.Append(",");
      AppendNumber(out, c.pps_offset_ms, true, 4);
      out.Append(",").Append(std::string_view(&c.pps_edge, 1));
      return true;
    case 'e':
      out.Append(std::string_view(&c.event_edge, 1));
      return true;
    case 's':
      out.Append("Y");
      return c.save;
    default:
      return false;
  }
}

}  // namespace

std::span<const ZXtremeStep> ZXtremeSteps() { return kSteps; }

ZXtremeCommand MakeCommand(const ZXtremeStep& step, const ZXtremeConfig& config, char data_port) {
  ZXtremeCommand command("$");
  for (const char* p = step.command; *p != '\0'; ++p) {
    if (*p != '%') {
      command.Append(std::string_view(p, 1));
    } else if (!Expand(*++p, config, data_port, command)) {
      return {};
    }
  }
  constexpr std::string_view kHex = "0123456789ABCDEF";
  const std::uint8_t sum = NmeaChecksum(command.view().substr(1));
  command.Append("*").Append(kHex.substr(sum >> 4, 1)).Append(kHex.substr(sum & 15U, 1));
  command.Append("\r\n");
  return command;
}

}  // namespace kawara::drivers
