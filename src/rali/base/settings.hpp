#pragma once

#include <array>
#include <string_view>

namespace rali {

/// How a module declares its settings. Each settings struct has
///
///   template <class V> void visit(V& v) {
///     v("window_s", window_s, 0.1, 10.0, "length of the line fitted to past ranges");   // number
///     v("project", project, "drop the height difference");                              // bool
///     v.choice("root", root, kRootNames, "which of two solutions");                     // enum
///     v("eta", eta, 0.0, 1.0, "weights of range, neighbours, motion");       // std::array<double>
///     v("kind", kind, "free text");                                                     // string
///     v.group("noise", noise, "data-sheet noise");                            // nested struct
///   }
///
/// One list of fields gives loading, unknown-key and range errors, help, the manual, the dump
/// settings.yaml and the hash. Visitors are in module `config`. Numbers are double, int or
/// std::size_t; an enumeration is listed as an array of names in the order of its values.
template <std::size_t N>
using ChoiceNames = std::array<std::string_view, N>;

}  // namespace rali
