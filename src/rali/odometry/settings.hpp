#pragma once
#include "rali/base/settings.hpp"
