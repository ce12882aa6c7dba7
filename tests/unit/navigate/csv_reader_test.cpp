#include "tools/navigate/csv_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/navigate/test_files.hpp"
#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = CsvColumn::Kind;

constexpr std::array<CsvColumn, 3> kColumns{
    {{"t", Kind::kTime}, {"x"}, {"y", Kind::kOptionalNumber}}};

struct Result {
  std::vector<double> t, x, y;
  CsvReport report;
  std::string error;
};

class CsvReaderTest : public WithFiles {
 protected:
  static Result ReadPath(const std::string& path,
                         CsvReader::Header header = CsvReader::Header::kRequired) {
    Result result;
    auto reader = CsvReader::Open(path, kColumns, header);
    if (!reader) {
      result.error = reader.error().message;
      return result;
    }
    for (;;) {
      const auto row = reader->Next();
      if (!row) {
        result.error = row.error().message;
        break;
      }
      if (!*row) break;
      result.t.push_back(SecondsOf(*(*row)->time[0]));
      result.x.push_back((*row)->number[1]);
      result.y.push_back((*row)->number[2]);
    }
    result.report = reader->report();
    return result;
  }
  Result Read(const std::string& text) const { return ReadPath(File(text)); }
};

TEST_F(CsvReaderTest, ColumnsByNameInAnyOrder) {
  const Result r = Read("y,t,x\n3,1.5,2\n6,2.5,5\n");
  EXPECT_THAT(r.t, ElementsAre(1.5, 2.5));
  EXPECT_THAT(r.x, ElementsAre(2.0, 5.0));
  EXPECT_THAT(r.y, ElementsAre(3.0, 6.0));
  EXPECT_THAT(r.report.Lines(), IsEmpty());
}

TEST_F(CsvReaderTest, DressOfTheTextDoesNotMatter) {
  const std::string plain = "t,x\n1,2\n3,4\n";
  for (const std::string& text : std::vector<std::string>{
           plain, "t,x\r\n1,2\r\n3,4\r\n", "t,x\n1,2\n3,4", "\xEF\xBB\xBFt,x\n1,2\n3,4\n",
           "# remark\n\nt,x\n# another, with comma\n1,2\n\n   \n3,4\n",
           " t , x \n 1 ,\t2\n3 , 4 \n", "\"t\",\"x\"\n\"1\",\"2\"\n3,4\n",
           "t,x\n1.0e0,+2\n3,4e0\n"}) {
    const Result r = Read(text);
    EXPECT_EQ(r.error, "") << text;
    EXPECT_THAT(r.t, ElementsAre(1.0, 3.0)) << text;
    EXPECT_THAT(r.x, ElementsAre(2.0, 4.0)) << text;
  }
}

TEST_F(CsvReaderTest, GzipIsToldByContent) {
  EXPECT_THAT(ReadPath(GzipFile("t,x\n1,2\n3,4\n", "plain-name.csv")).x, ElementsAre(2.0, 4.0));
  EXPECT_THAT(ReadPath(File("t,x\n1,2\n3,4\n", "liar.csv.gz")).x, ElementsAre(2.0, 4.0));
}

TEST_F(CsvReaderTest, CutGzipIsAnError) {
  std::string long_text = "t,x\n";
  for (int i = 0; i < 20000; ++i) {
    long_text += std::to_string(i) + "," + std::to_string(i * 7919 % 104729) + "\n";
  }
  const std::string path = GzipFile(long_text);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_THAT(ReadPath(path).error, HasSubstr("damaged or cut gzip"));
}

TEST_F(CsvReaderTest, OptionalCellsMayBeUnknown) {
  const Result r = Read("t,x,y\n1,1,nan\n2,1,\n3,1,NaN\n4,1,5\n");
  EXPECT_TRUE(std::isnan(r.y[0]) && std::isnan(r.y[1]) && std::isnan(r.y[2]));
  EXPECT_EQ(r.y[3], 5.0);
  EXPECT_EQ(r.report.bad_rows, 0);
}

TEST_F(CsvReaderTest, UnusedColumnsAreNamedOnce) {
  const Result r = Read("t,mood,x,weather\n1,glad,2,rain\n2,sad,3,sun\n");
  EXPECT_THAT(r.x, ElementsAre(2.0, 3.0));
  EXPECT_THAT(r.report.Lines(), ElementsAre(HasSubstr("file.csv: not used: mood, weather")));
}

TEST_F(CsvReaderTest, ABadRowCostsItselfOnly) {
  struct Case {
    const char* row;
    const char* complaint;
  };
  for (const Case& c : std::vector<Case>{{"2,abc,1", "file.csv:3: x is 'abc': not a number"},
                                         {"2,1.5.2,1", "x is '1.5.2': not a number"},
                                         {"2,,1", "x is '': not a number"},
                                         {"2,nan,1", "x is 'nan': not a finite number"},
                                         {"2,inf,1", "x is 'inf': not a finite number"},
                                         {"2,1,inf", "y is 'inf': not a finite number"},
                                         {"2,1,two", "y is 'two': not a number"},
                                         {"2,1e999,1", "x is '1e999': not a number"},
                                         {"9e99,1,1", "t is '9e99': no time"},
                                         {"2,1", "expected 3 fields, found 2"},
                                         {"2,1,1,1", "expected 3 fields, found 4"},
                                         {"2;1;1", "expected 3 fields, found 1"},
                                         {"\x1b[31m,1,1", "t is '?[31m': not a number"}}) {
    const Result r = Read(std::string("t,x,y\n1,10,1\n") + c.row + "\n3,30,1\n");
    EXPECT_EQ(r.error, "") << c.row;
    EXPECT_THAT(r.x, ElementsAre(10.0, 30.0)) << c.row;
    ASSERT_EQ(r.report.bad_rows, 1) << c.row;
    EXPECT_THAT(r.report.complaints.front(), HasSubstr(c.complaint));
  }
}

TEST_F(CsvReaderTest, ManyBadRowsAreCountedNotListed) {
  std::string text = "t,x,y\n";
  for (int i = 0; i < 100; ++i) text += std::to_string(i) + (i % 4 == 0 ? ",?,1\n" : ",1,1\n");
  const Result r = Read(text);
  EXPECT_EQ(r.report.bad_rows, 25);
  EXPECT_EQ(r.report.good_rows, 75);
  EXPECT_THAT(r.report.Lines(), ::testing::SizeIs(4));
  EXPECT_THAT(r.report.Lines().back(), HasSubstr("25 rows of 100 left out"));
}

TEST_F(CsvReaderTest, AFileOfMostlyBadRowsIsRefused) {
  const Result r = Read("t,x,y\n1,a,1\n2,b,1\n3,3,1\n");
  EXPECT_THAT(r.error, HasSubstr("file.csv:2: x is 'a': not a number; so or similar 2 of 3 rows"));
}

TEST_F(CsvReaderTest, MistakesOfTheHeader) {
  struct Case {
    std::string text;
    const char* error;
  };
  for (const Case& c : std::vector<Case>{
           {"", "empty, expected a header line with t, x"},
           {"# only a remark\n", "empty, expected a header line with t, x"},
           {"t,x,y\n", "no rows behind the header"},
           {"t,z\n1,2\n", ":1: no column 'x' (there are: t, z)"},
           {"\n# r\ntime,x\n1,2\n", ":3: no column 't'"},
           {"t,x,x\n1,2,3\n", ":1: column 'x' is there more than once"},
           {"1,2,3\n4,5,6\n", ":1: expected a header line with t, x, found numbers"},
           {"t;x;y\n1;2;3\n", ":1: no column 't'"},
       }) {
    EXPECT_THAT(Read(c.text).error, HasSubstr(c.error)) << c.text;
  }
}

TEST_F(CsvReaderTest, HeaderMayBeLeftOutWhereTold) {
  const std::string path = File("1,10\n2,20\n");
  EXPECT_THAT(ReadPath(path, CsvReader::Header::kOptional).x, ElementsAre(10.0, 20.0));
}

TEST_F(CsvReaderTest, NoSuchFileDirectoryAndBinary) {
  EXPECT_THAT(ReadPath(Path("missing.csv")).error, HasSubstr("No such file"));
  EXPECT_THAT(ReadPath(Path("")).error, HasSubstr("is a directory"));
  EXPECT_THAT(Read(std::string(100'000, '\0')).error, HasSubstr("a line of more than 64 KB"));
}

TEST_F(CsvReaderTest, LinesAcrossBlocksAreWhole) {
  std::string text = "t,x,y\n";
  for (int i = 0; i < 60'000; ++i) text += std::to_string(i) + "," + std::to_string(i) + ",1\n";
  const Result r = Read(text);
  ASSERT_EQ(r.x.size(), 60'000U);
  for (int i = 0; i < 60'000; ++i) ASSERT_EQ(r.x[static_cast<std::size_t>(i)], i);
}

TEST_F(CsvReaderTest, RejectedByTheCallerCountsAsBad) {
  auto reader = CsvReader::Open(File("t,x,y\n1,1,1\n2,2,1\n3,3,1\n"), kColumns);
  ASSERT_TRUE(reader);
  ASSERT_TRUE(reader->Next());
  reader->Reject("x must be larger");
  while (reader->Next()->has_value()) {
  }
  EXPECT_EQ(reader->report().good_rows, 2);
  EXPECT_THAT(reader->report().complaints, ElementsAre(HasSubstr("file.csv:2: x must be larger")));
}

}  // namespace
}  // namespace kawara::navigate
