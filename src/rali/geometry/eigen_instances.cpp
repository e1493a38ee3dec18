#define RALI_EIGEN_INSTANCE template
#include "rali/geometry/eigen_instances.hpp"
