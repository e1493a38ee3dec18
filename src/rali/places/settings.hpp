#pragma once

#include "rali/places/recognise.hpp"

namespace rali::places {

/// All settings of module `places`.
struct PlacesSettings {
  SubmapSettings submap;
  DescriptorSettings descriptor;
  NearSettings near;
  RecogniseSettings recognise;

  template <class V>
  void visit(V& v) {
    v.group("submap", submap, "submaps that are compared");
    v.group("descriptor", descriptor, "likeness without a guess");
    v.group("near", near, "candidates by the graph's prediction");
    v.group("recognise", recognise, "registration and its verification");
  }
};

}  // namespace rali::places
