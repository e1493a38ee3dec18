#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

// Tables of real ranges and statistics of their errors.
namespace rali::sim {

/// A table with a header line; cells that are not numbers become NaN.
struct Table {
  std::map<std::string, std::size_t> column;
  std::vector<std::vector<double>> rows;

  [[nodiscard]] double at(std::size_t row, const std::string& name) const {
    return rows[row][column.at(name)];
  }
};

inline std::vector<std::string> split(const std::string& line, char sign) {
  std::vector<std::string> cells;
  std::size_t from = 0;
  while (from <= line.size()) {
    const std::size_t to = std::min(line.find(sign, from), line.size());
    cells.push_back(line.substr(from, to - from));
    from = to + 1;
  }
  return cells;
}

inline Table read_table(const std::filesystem::path& path) {
  Table table;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> cells = split(line, ',');
    if (table.column.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) table.column[cells[i]] = i;
      continue;
    }
    std::vector<double> row;
    for (const std::string& cell : cells) {
      char* end = nullptr;
      const double value = std::strtod(cell.c_str(), &end);
      row.push_back(end == cell.c_str() ? std::nan("") : value);
    }
    row.resize(table.column.size(), std::nan(""));
    table.rows.push_back(std::move(row));
  }
  return table;
}

struct Figures {
  std::size_t count = 0;
  double mean = 0.0, sd = 0.0, p1 = 0.0, p50 = 0.0, p99 = 0.0;
};

inline Figures figures_of(std::vector<double> v) {
  Figures f;
  f.count = v.size();
  if (v.empty()) return f;
  std::sort(v.begin(), v.end());
  const double n = static_cast<double>(v.size());
  for (const double x : v) f.mean += x / n;
  for (const double x : v) f.sd += (x - f.mean) * (x - f.mean) / n;
  f.sd = std::sqrt(f.sd);
  const auto quantile = [&](double q) {
    return v[std::min(v.size() - 1, static_cast<std::size_t>(q * n))];
  };
  f.p1 = quantile(0.01);
  f.p50 = quantile(0.5);
  f.p99 = quantile(0.99);
  return f;
}

inline std::vector<double> within(const std::vector<double>& v, double limit) {
  std::vector<double> kept;
  std::copy_if(v.begin(), v.end(), std::back_inserter(kept),
               [&](double x) { return std::abs(x) <= limit; });
  return kept;
}

inline std::vector<double> less_median(const std::vector<double>& v) {
  const double median = figures_of(v).p50;
  std::vector<double> rest;
  for (const double x : v) rest.push_back(x - median);
  return rest;
}

inline void append(std::vector<double>& to, const std::vector<double>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

}  // namespace rali::sim
