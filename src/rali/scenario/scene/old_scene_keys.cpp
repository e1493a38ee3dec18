#include "rali/scenario/scene/old_scene_keys.hpp"

#include <array>
#include <utility>

#include "rali/config/key_changes.hpp"

namespace rali::scenario {
namespace {

using config::RenamedKey;

constexpr std::array kRenamed{
    RenamedKey{"escorts.begin_s", "escorts.start_s"},
    RenamedKey{"motion.jolts.felt_ratio", "motion.jolts.measured_ratio"},
    RenamedKey{"motion.rest_s", "motion.standstill_s"},
    RenamedKey{"radio.loss_share", "radio.loss_fraction"},
    RenamedKey{"radio.most_queue_s", "radio.max_queue_s"},
    RenamedKey{"radio.most_wall_loss_db", "radio.max_wall_loss_db"},
    RenamedKey{"ranging.mixed_share", "ranging.mixed_fraction"},
    RenamedKey{"tunnel.piece_curvature_per_m", "tunnel.segment_curvature_per_m"},
    RenamedKey{"tunnel.piece_gradient", "tunnel.segment_gradient"},
    RenamedKey{"tunnel.piece_m", "tunnel.segment_m"},
    RenamedKey{"uwb.blocked_burst_share", "uwb.blocked_burst_fraction"},
    RenamedKey{"uwb.clear_burst_share", "uwb.clear_burst_fraction"},
    RenamedKey{"uwb.loss_share", "uwb.loss_fraction"},
    RenamedKey{"uwb.outlier_share", "uwb.outlier_fraction"},
};

constexpr config::KeyChanges kChanges{kRenamed, {}, ""};

}  // namespace

config::Node with_current_scene_keys(config::Node root, std::vector<std::string>& notices) {
  config::apply_key_changes(kChanges, root, notices);
  return root;
}

}  // namespace rali::scenario
