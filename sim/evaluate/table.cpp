#include "sim/evaluate/table.hpp"

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <charconv>
#include <filesystem>
#include <limits>
#include <memory>

namespace kawara::sim {
namespace {

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, DatasetCloser>;

OGRLayer* LayerOf(GDALDataset& dataset, const std::vector<std::string>& names) {
  if (dataset.GetLayerCount() == 1 && std::string(dataset.GetDriverName()) == "CSV") {
    return dataset.GetLayer(0);
  }
  for (const std::string& name : names) {
    if (OGRLayer* layer = dataset.GetLayerByName(name.c_str())) return layer;
  }
  return nullptr;
}

std::string Join(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// Whole text or nothing.
template <class T>
bool Parse(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

core::Expected<Table> Table::Read(const std::string& path, const std::vector<std::string>& layers) {
  if (!std::filesystem::exists(path)) {
    return core::Fail(core::ErrorCode::kNotFound, path + ": no such file");
  }
  GDALAllRegister();
  CPLPushErrorHandler(CPLQuietErrorHandler);
  const Dataset dataset(GDALDataset::Open(
      path.c_str(),
      static_cast<unsigned>(GDAL_OF_VECTOR) | static_cast<unsigned>(GDAL_OF_READONLY)));
  CPLPopErrorHandler();
  if (!dataset) {
    return core::Fail(core::ErrorCode::kFormat,
                      path + ": neither CSV nor anything else GDAL reads as a table");
  }
  OGRLayer* layer = LayerOf(*dataset, layers);
  if (layer == nullptr) {
    std::vector<std::string> present;
    for (int i = 0; i < dataset->GetLayerCount(); ++i) {
      present.emplace_back(dataset->GetLayer(i)->GetName());
    }
    return core::Fail(core::ErrorCode::kFormat, path + ": has none of the tables " + Join(layers) +
                                                    ", only " + Join(present));
  }
  Table table;
  table.path_ = path;
  OGRFeatureDefn& fields = *layer->GetLayerDefn();
  std::vector<std::vector<std::string>*> columns;
  for (int i = 0; i < fields.GetFieldCount(); ++i) {
    columns.push_back(&table.columns_[fields.GetFieldDefn(i)->GetNameRef()]);
  }
  for (const auto& feature : *layer) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      columns[i]->emplace_back(feature->GetFieldAsString(static_cast<int>(i)));
    }
    ++table.size_;
  }
  return table;
}

core::Expected<std::string> Table::ColumnOf(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (Has(name)) return name;
  }
  std::vector<std::string> present;
  for (const auto& [name, cells] : columns_) present.push_back(name);
  return core::Fail(core::ErrorCode::kFormat,
                    path_ + ": no column " + Join(names) + "; there are " + Join(present));
}

double Table::Number(std::size_t row, const std::string& column) const {
  double value = 0.0;
  return Parse(Text(row, column), value) ? value : std::numeric_limits<double>::quiet_NaN();
}

std::int64_t Table::Integer(std::size_t row, const std::string& column) const {
  std::int64_t value = 0;
  return Parse(Text(row, column), value) ? value : 0;
}

const std::string& Table::Text(std::size_t row, const std::string& column) const {
  return columns_.at(column).at(row);
}

}  // namespace kawara::sim
