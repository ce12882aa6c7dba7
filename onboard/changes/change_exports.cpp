#include "onboard/changes/change_exports.hpp"

#include <chrono>

#include "gis/kiwi/kiwi_csv.hpp"
#include "gis/kiwi/object_exports.hpp"
#include "gis/model/model_writers.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::changes {

core::Expected<void> WriteExports(const ChangeRunOptions& options, const ChangeRunResult& result,
                                  const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder / "kiwi_plus", error);
  if (error)
    return core::Fail(core::ErrorCode::kIo,
                      folder.string() + ": cannot be made: " + error.message());
  gis::SurveyObjects survey;
  survey.origin = result.origin;
  survey.survey = options.survey;
  survey.objects = result.objects;
  survey.stations = result.stations;
  const auto boxes = gis::BoxMeshes(survey);
  auto done = gis::WriteObjectsGeoJson(folder / "changes.geojson", survey);
  if (done) done = gis::WriteObjectsKmz(folder / "changes.kmz", survey);
  if (done) done = gis::WriteObjectsCityJson(folder / "changes.city.json", survey);
  if (done) done = gis::WriteVrml(folder / "changes.wrl", boxes, survey.origin);
  if (done) done = gis::WriteGlb(folder / "changes.glb", boxes, survey.origin);
  for (const core::ChangedObject& object : survey.objects) {
    // A team's telephone forgets a blockade that nobody has confirmed for a day.
    const core::UtcTime stale = options.time + std::chrono::hours(24);
    if (done)
      done =
          gis::WriteWholeFile(folder / (object.uid + ".cot.xml"),
                              gis::CursorOnTargetEvent(object, survey.origin, options.time, stale));
  }
  if (!done) return done;
  gis::KiwiCsv twin(folder / "kiwi_plus");
  if (auto replayed = gis::ReplayKiwiPlus(options.out, twin); !replayed) return replayed;
  return twin.Finish();
}

}  // namespace kawara::changes
