#include "vision/panorama_metadata.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "vision/jpeg.hpp"
#include "vision/jpeg_segments.hpp"
#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

constexpr double kDeg = core::kRadFromDeg;

PanoramaMetadata Example() {
  PanoramaMetadata m;
  m.time = core::FromCivil({2026, 11, 22, 23, 59, 59, 123456789});
  m.position = core::Geodetic{35.7061234567891 * kDeg, -139.7201234567891 * kDeg, 78.12345};
  m.geoid_separation_m = 36.7123;
  m.position_cov_enu_m2 << 1e-4, 2e-6, 3e-6, 2e-6, 2e-4, 4e-6, 3e-6, 4e-6, 9e-4;
  m.rtk = core::RtkState::kFixed;
  m.gnss_age_s = 0.25;
  m.hdop = 0.9;
  m.attitude = core::Attitude{-1.5 * kDeg, 2.25 * kDeg, -90.125 * kDeg};
  m.attitude_sd_rad = Eigen::Vector3d(0.1, 0.11, 0.5) * kDeg;
  m.geometry = PanoramaGeometry::Band(64, {-50 * kDeg, 30 * kDeg});
  m.make = "Kawaraban";
  m.model = "ODV <\"&\">";
  m.robot = "robot-1";
  m.mission = "20261122T235900Z";
  m.epoch = 42;
  return m;
}

std::vector<std::uint8_t> Picture(int width_px = 64, int height_px = 14) {
  JpegEncoder encoder;
  const auto jpeg = encoder.Encode(WaveImage(width_px, height_px).view(), {});
  return {jpeg->begin(), jpeg->end()};
}

std::vector<std::uint8_t> With(const PanoramaMetadata& m, const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> out;
  const auto inserted = InsertPanoramaMetadata(jpeg, m, &out);
  EXPECT_TRUE(inserted) << inserted.error().message;
  return out;
}

double MetresApart(const core::Geodetic& a, const core::Geodetic& b) {
  return (core::EcefFromGeodetic(a) - core::EcefFromGeodetic(b)).norm();
}

// What a program of somebody else says about the picture. Empty: it is not installed.
std::string Output(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    text.append(buffer.data(), n);
  pclose(pipe);
  return text;
}

bool Installed(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

struct TemporaryFile {
  explicit TemporaryFile(const std::vector<std::uint8_t>& bytes) {
    path = std::filesystem::temp_directory_path() /
           ("kawara_metadata_" + std::to_string(std::random_device{}()) + ".jpg");
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
};

// exiftool -n -G1 -s: "[Group] Tag : value".
std::map<std::string, std::string> ExifToolTags(const std::vector<std::uint8_t>& jpeg) {
  const TemporaryFile file(jpeg);
  std::istringstream lines(Output("exiftool -n -a -G1 -s " + file.path.string()));
  std::map<std::string, std::string> tags;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t close = line.find(']'), colon = line.find(" : ");
    if (close == std::string::npos || colon == std::string::npos) continue;
    std::string tag = line.substr(close + 1, colon - close - 1);
    tag.erase(std::remove(tag.begin(), tag.end(), ' '), tag.end());
    tags[line.substr(1, close - 1) + ":" + tag] = line.substr(colon + 3);
  }
  return tags;
}

TEST(PanoramaMetadata, ReadsBackWhatWasWritten) {
  const PanoramaMetadata m = Example();
  const auto back = ReadPanoramaMetadata(With(m, Picture()));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->time->ns(), m.time->ns());
  EXPECT_LT(MetresApart(*back->position, *m.position), 1e-5);
  EXPECT_NEAR(back->geoid_separation_m, m.geoid_separation_m, 1e-12);
  EXPECT_LT((back->position_cov_enu_m2 - m.position_cov_enu_m2).norm(), 1e-15);
  EXPECT_EQ(back->rtk, m.rtk);
  EXPECT_DOUBLE_EQ(back->gnss_age_s, m.gnss_age_s);
  EXPECT_DOUBLE_EQ(back->hdop, m.hdop);
  EXPECT_NEAR(back->attitude->roll_rad, m.attitude->roll_rad, 1e-9);
  EXPECT_NEAR(back->attitude->pitch_rad, m.attitude->pitch_rad, 1e-9);
  EXPECT_NEAR(back->attitude->yaw_rad, m.attitude->yaw_rad, 1e-9);
  EXPECT_LT((back->attitude_sd_rad - m.attitude_sd_rad).norm(), 1e-12);
  EXPECT_EQ(back->geometry, m.geometry);
  EXPECT_EQ(back->make, m.make);
  EXPECT_EQ(back->model, m.model);
  EXPECT_EQ(back->robot, m.robot);
  EXPECT_EQ(back->mission, m.mission);
  EXPECT_EQ(back->epoch, m.epoch);
}

// Somebody who reads the standard tags alone must get the same place and time.
TEST(PanoramaMetadata, StandardTagsKeepATenthOfAMillimetre) {
  if (!Installed("exiftool")) GTEST_SKIP() << "exiftool is not installed (packages.txt)";
  struct Case {
    double lat_deg, lon_deg, h_m;
  };
  for (const Case& c :
       {Case{35.7061234567891, -139.7201234567891, 78.12345},
        Case{-0.0000000123, 0.0000000123, -12.3456}, Case{59.99999999999, 179.99999999999, 0.00004},
        Case{-90.0, -180.0, 8848.8612}}) {
    PanoramaMetadata m = Example();
    m.position = core::Geodetic{c.lat_deg * kDeg, c.lon_deg * kDeg, c.h_m};
    m.geoid_separation_m = 0.0;
    auto tags = ExifToolTags(With(m, Picture()));
    const double sign_lat = tags["GPS:GPSLatitudeRef"] == "S" ? -1 : 1;
    const double sign_lon = tags["GPS:GPSLongitudeRef"] == "W" ? -1 : 1;
    const double sign_h = tags["GPS:GPSAltitudeRef"] == "1" ? -1 : 1;
    const core::Geodetic read{sign_lat * std::stod(tags["GPS:GPSLatitude"]) * kDeg,
                              sign_lon * std::stod(tags["GPS:GPSLongitude"]) * kDeg,
                              sign_h * std::stod(tags["GPS:GPSAltitude"])};
    EXPECT_LT(MetresApart(read, *m.position), 1e-4) << c.lat_deg << " " << tags["GPS:GPSLatitude"];
  }
}

TEST(PanoramaMetadata, ExifToolFindsEveryTagAndNothingToWarnAbout) {
  if (!Installed("exiftool")) GTEST_SKIP() << "exiftool is not installed (packages.txt)";
  const auto jpeg = With(Example(), Picture());
  const TemporaryFile file(jpeg);
  const std::string validation =
      Output("exiftool -validate -warning -error -a " + file.path.string());
  EXPECT_NE(validation.find(": OK"), std::string::npos) << validation;
  EXPECT_EQ(validation.find("arning"), std::string::npos) << validation;
  auto tags = ExifToolTags(jpeg);
  const std::pair<const char*, const char*> expected[] = {
      {"IFD0:Make", "Kawaraban"},
      {"IFD0:Model", "ODV <\"&\">"},
      {"ExifIFD:DateTimeOriginal", "2026:11:22 23:59:59"},
      {"ExifIFD:SubSecTimeOriginal", "123456789"},
      {"ExifIFD:OffsetTimeOriginal", "+00:00"},
      {"ExifIFD:ExifImageWidth", "64"},
      {"ExifIFD:ExifImageHeight", "14"},
      {"GPS:GPSDateStamp", "2026:11:22"},
      {"GPS:GPSMapDatum", "WGS-84"},
      {"GPS:GPSImgDirectionRef", "T"},
      {"GPS:GPSImgDirection", "269.875"},
      {"GPS:GPSDOP", "0.9"},
      {"GPS:GPSHPositioningError", "0.0173"},
      {"GPS:GPSAltitude", "41.4112"},  // 78.12345 - 36.7123
      {"GPS:GPSDifferential", "1"},
      {"XMP-GPano:ProjectionType", "equirectangular"},
      {"XMP-GPano:UsePanoramaViewer", "True"},
      {"XMP-GPano:CroppedAreaImageWidthPixels", "64"},
      {"XMP-GPano:CroppedAreaImageHeightPixels", "14"},
      {"XMP-GPano:FullPanoWidthPixels", "64"},
      {"XMP-GPano:FullPanoHeightPixels", "32"},
      {"XMP-GPano:CroppedAreaLeftPixels", "0"},
      {"XMP-GPano:CroppedAreaTopPixels", "11"},
      {"XMP-GPano:PoseHeadingDegrees", "269.8750"},
      {"XMP-GPano:PosePitchDegrees", "2.2500"},
      {"XMP-GPano:PoseRollDegrees", "-1.5000"},
      {"XMP-GPano:InitialViewHeadingDegrees", "270"},
      {"XMP-GPano:FirstPhotoDate", "2026:11:22 23:59:59.123456789Z"},
      {"XMP-kawara:RtkState", "fixed"},
      {"XMP-kawara:EllipsoidalHeight", "78.12345"},
      {"XMP-kawara:PositionCovarianceENU", "1e-04 2e-06 3e-06 2e-04 4e-06 9e-04"},
  };
  for (const auto& [tag, value] : expected) EXPECT_EQ(tags[tag], value) << tag;
  EXPECT_EQ(tags["GPS:GPSTimeStamp"].substr(0, 11), "23:59:59.12");
  EXPECT_EQ(tags["ExifIFD:ImageUniqueID"], ImageUniqueId(Example()));
}

TEST(PanoramaMetadata, Exiv2ReadsItWithoutComplaint) {
  if (!Installed("exiv2")) GTEST_SKIP() << "exiv2 is not installed (packages.txt)";
  const TemporaryFile file(With(Example(), Picture()));
  const std::string text = Output("exiv2 -pa " + file.path.string());
  for (const char* expected : {"Exif.GPSInfo.GPSLatitude ", "Exif.Photo.SubSecTimeOriginal",
                               "Xmp.GPano.PoseHeadingDegrees"}) {
    EXPECT_NE(text.find(expected), std::string::npos) << expected;
  }
  EXPECT_EQ(text.find("Warning:"), std::string::npos) << text;
  EXPECT_EQ(text.find("Error:"), std::string::npos) << text;
}

TEST(PanoramaMetadata, AnUnknownGeoidIsSaid) {
  PanoramaMetadata m = Example();
  m.geoid_separation_m = std::nan("");
  const auto jpeg = With(m, Picture());
  const auto back = ReadPanoramaMetadata(jpeg);
  EXPECT_TRUE(std::isnan(back->geoid_separation_m));
  EXPECT_NEAR(back->position->h_ellipsoidal_m, 78.12345, 1e-9);
  if (!Installed("exiftool")) return;
  auto tags = ExifToolTags(jpeg);
  EXPECT_EQ(tags["GPS:GPSAltitude"], "78.1235");
  EXPECT_NE(tags["ExifIFD:UserComment"].find("ellipsoid"), std::string::npos);
}

TEST(PanoramaMetadata, ThePictureItselfIsNotTouched) {
  const auto plain = Picture();
  const auto tagged = With(Example(), plain);
  JpegDecoder decoder;
  const TestImage before(*decoder.Decode(plain));
  EXPECT_EQ(TestImage(*decoder.Decode(tagged)).bytes, before.bytes);
  const auto a = SplitJpeg(plain), b = SplitJpeg(tagged);
  EXPECT_TRUE(std::equal(a->scan.begin(), a->scan.end(), b->scan.begin(), b->scan.end()));
}

TEST(PanoramaMetadata, WritingTwiceReplaces) {
  const PanoramaMetadata m = Example();
  PanoramaMetadata other = m;
  other.position->lat_rad = 0.1;
  other.epoch = 41;
  other.robot = "an older robot";
  const auto twice = With(m, With(other, Picture()));
  const auto back = ReadPanoramaMetadata(twice);
  EXPECT_LT(MetresApart(*back->position, *m.position), 1e-5);
  EXPECT_EQ(back->robot, m.robot);
  int exif = 0, xmp = 0;
  const auto parts = SplitJpeg(twice);
  for (const JpegSegment& segment : parts->header) {
    exif += segment.Is(kMarkerApp1, kExifSignature);
    xmp += segment.Is(kMarkerApp1, kXmpSignature);
  }
  EXPECT_EQ(exif, 1);
  EXPECT_EQ(xmp, 1);
}

TEST(PanoramaMetadata, ARealCamerasTagsAreReadAndKept) {
  const auto camera = ReadTestFile("data/panorama/R0014760_3072.jpg");
  const auto before = ReadPanoramaMetadata(camera);
  ASSERT_TRUE(before);
  EXPECT_NEAR(before->position->lat_rad * core::kDegFromRad, 53.18205, 1e-5);
  EXPECT_NEAR(before->position->lon_rad * core::kDegFromRad, -2.86126, 1e-5);
  EXPECT_NEAR(before->position->h_ellipsoidal_m, 63.34, 1e-9);
  EXPECT_EQ(before->model, "RICOH THETA V");
  EXPECT_EQ(before->geometry, PanoramaGeometry::Full(3072, 1536));
  EXPECT_EQ(before->time->ns(), core::FromCivil({2020, 5, 11, 10, 22, 57, 0}).ns());
  EXPECT_FALSE(before->attitude) << "the file has no heading";

  PanoramaMetadata m = Example();
  m.make.clear();
  m.model.clear();
  m.geometry = {};
  const auto merged = With(m, camera);
  const auto after = ReadPanoramaMetadata(merged);
  EXPECT_LT(MetresApart(*after->position, *m.position), 1e-5);
  EXPECT_EQ(after->model, "RICOH THETA V");
  EXPECT_EQ(after->geometry, before->geometry);
  if (!Installed("exiftool")) GTEST_SKIP() << "exiftool is not installed (packages.txt)";
  auto old_tags = ExifToolTags(camera), new_tags = ExifToolTags(merged);
  for (const char* kept : {"ExifIFD:ExposureTime", "ExifIFD:FNumber", "ExifIFD:ISO",
                           "Ricoh:SerialNumber", "Ricoh:TimeZone", "Ricoh:Accelerometer",
                           "InteropIFD:InteropIndex", "IFD1:ThumbnailLength"}) {
    EXPECT_FALSE(old_tags[kept].empty()) << kept;
    EXPECT_EQ(new_tags[kept], old_tags[kept]) << kept;
  }
  const TemporaryFile file(merged);
  const std::string validation =
      Output("exiftool -validate -warning -error -a " + file.path.string());
  EXPECT_NE(validation.find(": OK"), std::string::npos) << validation;
}

TEST(PanoramaMetadata, OtherNamespacesOfAnOldPacketStay) {
  const std::string old_packet =
      "<?xpacket begin='' id='W5M0MpCehiHzreSzNTczkc9d'?><x:xmpmeta xmlns:x='adobe:ns:meta/'>"
      "<r:RDF xmlns:r='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>"
      "<r:Description r:about='uuid:7' xmlns:dc='http://purl.org/dc/elements/1.1/' "
      "xmlns:pano='http://ns.google.com/photos/1.0/panorama/' pano:PoseHeadingDegrees='1.5' "
      "dc:source='a &amp; b'>"
      "<pano:ProjectionType>cylindrical</pano:ProjectionType><dc:subject><r:Bag><r:li>flood</"
      "r:li></r:Bag></dc:subject>"
      "</r:Description></r:RDF></x:xmpmeta><?xpacket end='w'?>";
  std::vector<std::uint8_t> jpeg = {0xFF, 0xD8};
  ASSERT_TRUE(AppendSegment(
      kMarkerApp1, kXmpSignature,
      {reinterpret_cast<const std::uint8_t*>(old_packet.data()), old_packet.size()}, &jpeg));
  const auto picture = Picture();
  jpeg.insert(jpeg.end(), picture.begin() + 2, picture.end());
  const auto merged = With(Example(), jpeg);
  const auto payload = SplitJpeg(merged)->Find(kMarkerApp1, kXmpSignature);
  const std::string packet(payload->begin(), payload->end());
  EXPECT_NE(packet.find("<r:li>flood</r:li>"), std::string::npos);
  EXPECT_NE(packet.find("dc:source='a &amp; b'"), std::string::npos);
  EXPECT_EQ(packet.find("cylindrical"), std::string::npos);
  EXPECT_EQ(packet.find("'1.5'"), std::string::npos);
  EXPECT_EQ(ReadPanoramaMetadata(merged)->geometry, Example().geometry);
  if (!Installed("exiftool")) return;
  auto tags = ExifToolTags(merged);
  EXPECT_EQ(tags["XMP-dc:Subject"], "flood");
  EXPECT_EQ(tags["XMP-GPano:PoseHeadingDegrees"], "269.8750");
}

TEST(PanoramaMetadata, DamagedBlocksAreReplaced) {
  const auto tagged = With(Example(), Picture());
  std::mt19937 random(9);
  const auto header = static_cast<std::size_t>(SplitJpeg(tagged)->scan.data() - tagged.data());
  for (int i = 0; i < 3000; ++i) {
    auto spoiled = tagged;
    for (int k = 0; k < 4; ++k) spoiled[random() % header] = static_cast<std::uint8_t>(random());
    (void)ReadPanoramaMetadata(spoiled);  // whatever it finds, it must come back
    std::vector<std::uint8_t> mended;
    if (!InsertPanoramaMetadata(spoiled, Example(), &mended)) continue;
    const auto back = ReadPanoramaMetadata(mended);
    ASSERT_TRUE(back);
    ASSERT_TRUE(back->position);
    ASSERT_LT(MetresApart(*back->position, *Example().position), 1e-4);
  }
}

TEST(PanoramaMetadata, WhatIsNotAJpegIsAnError) {
  std::vector<std::uint8_t> out;
  for (const std::vector<std::uint8_t>& bytes : {std::vector<std::uint8_t>{},
                                                 {0xFF, 0xD8},
                                                 {'P', 'N', 'G', 0, 0, 0},
                                                 {0xFF, 0xD8, 0xFF, 0xE1, 0xFF, 0xFF, 0}}) {
    EXPECT_EQ(ReadPanoramaMetadata(bytes).error().code, core::ErrorCode::kFormat);
    EXPECT_FALSE(InsertPanoramaMetadata(bytes, Example(), &out));
  }
}

TEST(PanoramaMetadata, NothingKnownWritesNothingFalse) {
  PanoramaMetadata nothing;
  const auto back = ReadPanoramaMetadata(With(nothing, Picture()));
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->time);
  EXPECT_FALSE(back->position);
  EXPECT_FALSE(back->attitude);
  EXPECT_EQ(back->geometry.width_px, 0);
}

TEST(PanoramaMetadata, UniqueIdDiffersByPictureAndRepeats) {
  PanoramaMetadata a = Example(), b = Example();
  EXPECT_EQ(ImageUniqueId(a), ImageUniqueId(b));
  EXPECT_EQ(ImageUniqueId(a).size(), 32u);
  b.epoch = 43;
  EXPECT_NE(ImageUniqueId(a), ImageUniqueId(b));
}

}  // namespace
}  // namespace kawara::vision
