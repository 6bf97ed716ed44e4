// Vectors are GLM's. World space and solids are double, mesh space is float; colours are linear RGB.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tilecast {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Vec3f = glm::vec3;
using Rgb = glm::dvec3;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kInvPi = 0.31830988618379067154;
inline constexpr double kUnitRoundoff = 0x1p-53;  // of double, "u" in the error bounds

inline double max_abs(const Vec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }
inline double max_component(const Vec3& v) { return std::max({v.x, v.y, v.z}); }
inline bool is_finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace tilecast
