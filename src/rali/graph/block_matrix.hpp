#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace rali::graph {

/// Lower triangle of a sparse symmetric matrix of dense blocks. A variable is one row and column of
/// blocks; it has 1 to some tens of unknowns.
class BlockMatrix {
 public:
  struct Entry {
    int row = 0;  ///< variable, >= column
    int column = 0;
    int offset = 0;  ///< of the first coefficient in values(), column by column
  };

  using Block = Eigen::Map<Eigen::MatrixXd>;
  using ConstBlock = Eigen::Map<const Eigen::MatrixXd>;

  BlockMatrix() = default;
  /// @param dims   unknowns of each variable
  /// @param pairs  of variables whose block exists; in any order, also twice. The diagonal always
  ///               exists.
  BlockMatrix(std::vector<int> dims, const std::vector<std::pair<int, int>>& pairs);

  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

  /// The block must exist and row >= column.
  [[nodiscard]] Block block(int row, int column);

  [[nodiscard]] ConstBlock block(const Entry& entry) const;

  [[nodiscard]] int variables() const { return static_cast<int>(dims_.size()); }

  [[nodiscard]] int dim(int variable) const { return dims_[static_cast<std::size_t>(variable)]; }

  [[nodiscard]] const std::vector<int>& dims() const { return dims_; }

  /// By column, then by row.
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<int> dims_;
  std::vector<std::size_t> begins_;  ///< of each column's entries, and the end
  std::vector<Entry> entries_;
  std::vector<double> values_;
};

}  // namespace rali::graph
