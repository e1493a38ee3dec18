#pragma once

#include <vector>

#include "rali/graph/block_matrix.hpp"

namespace rali::graph {

/// Variables that are eliminated together as one dense front: `pivots` first, then the coupled rows
/// below. Positions are those of Elimination::order.
struct Supernode {
  int first = 0;             ///< position of the first pivot; the others follow it
  int pivots = 0;            ///< variables
  std::vector<int> rows;     ///< positions of all variables of the front, ascending, pivots first
  std::vector<int> offsets;  ///< of the rows' unknowns in the front, and its size at the end
  int parent = -1;           ///< -1: a root
  /// For each row below the pivots, the position of its unknowns in the parent's front.
  std::vector<int> offsets_in_parent;

  [[nodiscard]] int pivot_size() const { return offsets[static_cast<std::size_t>(pivots)]; }

  [[nodiscard]] int size() const { return offsets.back(); }
};

/// Elimination order of a BlockMatrix and its fill-in (Liu 1992, multifrontal method).
struct Elimination {
  std::vector<int> order;             ///< variable at each position
  std::vector<int> position;          ///< of each variable
  std::vector<int> unknowns;          ///< first unknown of each variable in a vector
  std::vector<Supernode> supernodes;  ///< children before parents
  std::vector<int> supernode_at;      ///< of each position
  int size = 0;                       ///< unknowns in all

  /// Minimum degree (AMD) on the blocks. The variables `last` (ascending) come after all others in
  /// the given order: those coupled to many. With `keep_last` they form one front, which is never
  /// eliminated.
  Elimination(const BlockMatrix& matrix, const std::vector<int>& last, bool keep_last);
};

}  // namespace rali::graph
