// The localizer `dead_reckoning`: believes the odometer, and gets less sure with every meter and every turn.
#include "rumbo_plugin.hpp"

#include <cmath>

namespace {

constexpr const char *schema = R"({
    "type": "object",
    "additionalProperties": false,
    "properties": {
        "drift_m_per_m": {
            "type": "number", "default": 0.02, "minimum": 0.0,
            "description": "Growth of the deviation of the position with the way, meters per meter."
        },
        "drift_rad_per_rad": {
            "type": "number", "default": 0.02, "minimum": 0.0,
            "description": "Growth of the deviation of the heading with the turning, radians per radian."
        }
    }
})";

class DeadReckoning : public rumbo::localizer {
public:
    explicit DeadReckoning(const rumbo::setting &setting)
        : drift_m_per_m(setting.number("drift_m_per_m")), drift_rad_per_rad(setting.number("drift_rad_per_rad"))
    {
    }

    static void manifest(rumbo_manifest &manifest)
    {
        manifest.needs_start_pose = 1;
        manifest.consumes[0] = 1u << RUMBO_ODOMETRY;
        manifest.n_consumes = 1;
    }

    void start(const rumbo_prior &prior, const rumbo_map &) override
    {
        if (prior.kind != RUMBO_PRIOR_POSE)
            throw rumbo::failure(RUMBO_BAD_PRIOR, "cannot start from an unknown pose").of("an unknown pose").because("a pose");
        if (!is_finite(prior.map_from_base) || !is_finite(prior.odom_from_base) ||
            !std::all_of(std::begin(prior.covariance), std::end(prior.covariance), [](double v) { return std::isfinite(v); }))
            throw rumbo::failure(RUMBO_BAD_NUMBER, "cannot start from a pose that is not finite");
        is_started = true;
        odom_from_base = prior.odom_from_base;
        map_from_odom = rumbo_compose(prior.map_from_base, rumbo_inverse(prior.odom_from_base));
        position_deviation_m = std::sqrt(std::fmax(prior.covariance[0], prior.covariance[4]));
        heading_deviation_rad = std::sqrt(prior.covariance[8]);
        has_stamp = false;
    }

    void update(const rumbo_call &call, const rumbo_seen &seen, const rumbo_map &, rumbo_estimate &estimate,
                rumbo_candidate_out &) override
    {
        if (!is_started)
            throw rumbo::failure(RUMBO_NOT_STARTED, "it was not started");
        for (size_t k = 0; k < seen.len; k++) {
            const rumbo_observation &observation = *rumbo_seen_at(&seen, k);
            if (observation.kind == RUMBO_ODOMETRY && observation.valid != 0)
                advance(static_cast<const rumbo_odometry *>(observation.data)->odom_from_base, observation.stamp_ns);
        }
        estimate.stamp_ns = has_stamp ? stamp_ns : call.now_ns;
        estimate.map_from_odom = rumbo_lift(map_from_odom);
        estimate.map_from_base = rumbo_lift(rumbo_compose(map_from_odom, odom_from_base));
        std::fill(std::begin(estimate.covariance), std::end(estimate.covariance), 0.0);
        estimate.covariance[0 * 6 + 0] = estimate.covariance[1 * 6 + 1] = position_deviation_m * position_deviation_m;
        estimate.covariance[5 * 6 + 5] = heading_deviation_rad * heading_deviation_rad;
        estimate.status = RUMBO_TRACKING;
    }

private:
    static bool is_finite(const rumbo_pose2 &pose)
    {
        return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(rumbo_yaw(pose));
    }

    void advance(const rumbo_pose2 &to, int64_t at_ns)
    {
        if (!is_finite(to))
            throw rumbo::failure(RUMBO_BAD_NUMBER, "the odometer's pose is not finite");
        const rumbo_pose2 step = rumbo_compose(rumbo_inverse(odom_from_base), to);
        const double way_m = std::hypot(step.x_m, step.y_m);
        // Further than any robot drives between two readings; the next one is measured from the last good one.
        if (way_m > 1000.0)
            throw rumbo::failure(RUMBO_ERROR, "the odometer jumped; was it restarted?");
        heading_deviation_rad += drift_rad_per_rad * std::fabs(rumbo_yaw(step));
        // What is not known of the heading goes sideways on the way.
        position_deviation_m += way_m * (drift_m_per_m + heading_deviation_rad);
        odom_from_base = to;
        stamp_ns = at_ns;
        has_stamp = true;
    }

    double drift_m_per_m, drift_rad_per_rad;
    rumbo_pose2 map_from_odom{}, odom_from_base{};
    double position_deviation_m = 0.0, heading_deviation_rad = 0.0;
    int64_t stamp_ns = 0;
    bool has_stamp = false, is_started = false;
};

} // namespace

RUMBO_CPP_PLUGINS("dead_reckoning 1.0.0, " __VERSION__,
                  rumbo::entry<DeadReckoning>("dead_reckoning", "1.0.0", "Believes the odometer, in C++", schema))
