// What four hits of a plain scene mean, and what smooth surfaces make of directions: the same bits as one by one gives.
#pragma once

#include <cstddef>

#include "integrators/plain_hits.h"
#include "optics/fresnel_lanes.h"
#include "shading/basis_lanes.h"

namespace tilecast {

// Of the faces that were hit, row by row.
class PlainRows {
 public:
  PlainRows(const PlainScene& plain, Mask4 face) {
    for (int lane = 0; lane < kDoubles; ++lane)
      rows_[lane] = reinterpret_cast<const double*>(plain.faces.data() + std::max<int64_t>(face[lane], 0));
  }
  // From this offset in PlainScene::Face on.
  void look_up(size_t offset, Double4 (&out)[kDoubles]) const { turn(rows_, offset / sizeof(double), out); }

 private:
  const double* rows_[kDoubles];
};

struct PlainSurface {
  Vec3x4 point, up, outward;  // up: the normal on the viewer's side
  Double4 error;
  Vec3x4 colour;              // reflectance or tint
  Double4 area;               // of the sampled light that it is; 0: of none
  Mask4 mirror{}, glass{};    // none: chalk

  // As Surface has it.
  Vec3x4 spawn(const Vec3x4& towards) const {
    const Double4 side = dot(towards, outward) >= 0.0 ? error : -error;
    return point + side * outward;
  }
};

// resolve() of scene/surface.h. kChalk: PlainScene::chalk.
template <bool kChalk>
[[gnu::always_inline]] inline PlainSurface resolve(const PlainRows& rows, const Vec3x4& origin, const Vec3x4& direction, const PlainHits& hit) {
  using Face = PlainScene::Face;
  Double4 part[kDoubles], in[3][kDoubles], across[kDoubles], plane[kDoubles], leaf[3], world[3];
  for (int i = 0; i < 3; ++i) rows.look_up(offsetof(Face, to_local) + i * sizeof(Face::Row), in[i]);
  rows.look_up(offsetof(Face, across), across);
  rows.look_up(offsetof(Face, plane), plane);
  const Vec3x4 from{origin.x - in[0][3], origin.y - in[1][3], origin.z - in[2][3]};
  auto local = [&](int i, const Vec3x4& v) { return fma(in[i][0], v.x, fma(in[i][1], v.y, in[i][2] * v.z)); };
  for (int i = 0; i < 3; ++i) leaf[i] = (Mask4)across[i] ? plane[i] : local(i, from) + hit.t * local(i, direction);
  Double4 normal[kDoubles], colour[kDoubles];
  rows.look_up(offsetof(Face, normal), normal);
  rows.look_up(offsetof(Face, reflectance), colour);
  PlainSurface out;
  if constexpr (!kChalk) {
    Double4 looks[kDoubles];
    rows.look_up(offsetof(Face, mirror), looks);
    out.mirror = (Mask4)looks[0], out.glass = (Mask4)looks[1];
    if (const Mask4 round = (Mask4)looks[2]; bits(round)) {
      Double4 turned_row[kDoubles];
      rows.look_up(offsetof(Face, turned), turned_row);
      // Zeros keep their signs: the basis about a normal has them.
      const Mask4 turned = (Mask4)turned_row[0];
      const Double4 from_at[3]{from.x, from.y, from.z}, along[3]{direction.x, direction.y, direction.z};
      Double4 p[3], n[3];
      for (int i = 0; i < 3; ++i)
        p[i] = (turned ? local(i, from) + 0.0 : from_at[i]) + hit.t * (turned ? local(i, direction) + 0.0 : along[i]);
      const Vec3x4 arm{p[0], p[1], p[2]};
      const Double4 radius = looks[3], now = sqrt(dot(arm, arm)), stretch = radius / now;
      const Mask4 off_centre = now > 0.0;
      for (int i = 0; i < 3; ++i) p[i] = off_centre ? p[i] * stretch : i == 1 ? radius : all(0.0);
      for (int k = 0; k < 3; ++k) n[k] = turned ? in[0][k] * p[0] + in[1][k] * p[1] + in[2][k] * p[2] : p[k];
      const Vec3x4 any_length{n[0], n[1], n[2]};
      const Vec3x4 outwards = normalize(any_length * power_below_reciprocal(max_abs(any_length)));
      const Double4 normals[3]{outwards.x, outwards.y, outwards.z};
      for (int i = 0; i < 3; ++i) leaf[i] = round ? p[i] : leaf[i], normal[i] = round ? normals[i] : normal[i];
    }
  }
  for (int i = 0; i < 3; ++i) {
    rows.look_up(offsetof(Face, to_world) + i * sizeof(Face::Row), part);
    world[i] = fma(part[0], leaf[0], fma(part[1], leaf[1], fma(part[2], leaf[2], part[3])));
  }
  out.point = {world[0], world[1], world[2]};
  out.colour = {colour[0], colour[1], colour[2]};
  const Double4 leaf_size = max_abs(Vec3x4{leaf[0], leaf[1], leaf[2]});
  out.error = normal[3] * (colour[3] * leaf_size + 16 * kUnitRoundoff * leaf_size) +
              16 * kUnitRoundoff * (max_abs(out.point) + across[3]);
  const Vec3x4 n{normal[0], normal[1], normal[2]};
  const Mask4 behind = dot(n, direction) > 0.0;
  out.up = {behind ? -n.x : n.x, behind ? -n.y : n.y, behind ? -n.z : n.z};
  const Vec3x4& up = out.up;
  out.outward = {hit.entering ? up.x : -up.x, hit.entering ? up.y : -up.y, hit.entering ? up.z : -up.z};
  out.area = plane[3];
  return out;
}

}  // namespace tilecast
