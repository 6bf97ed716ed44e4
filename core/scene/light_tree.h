// A tree over lights, in which one of many is chosen for a place by how much it may bring there.
//
// Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018; the bounds on
// angles as in Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 12.6.3, about balls, not boxes. A node
// that the place is in or near is split before the choice, while few enough parts come of it: what one bound says of near
// and far lights together is worth little. So the choice is out of a cut through the tree (Walter et al., "Lightcuts",
// SIGGRAPH 2005), and goes down from there, at each node by the bounds on its halves.
#pragma once

#include <vector>

#include "base/box.h"

namespace tilecast {

// Where lights are and which way they shine: their normals lie within a cone, and light leaves within a further angle.
struct LightBounds {
  Box box;                    // world space, metres
  Vec3 axis{0.0, 0.0, 1.0};   // of the normals' cone, unit length
  double normals = 0.5;       // its half angle, turns: 0.5 is all directions
  double cos_emission = 0.0;  // of the angle between a normal and the light
  double intensity = 0.0;     // the most that they send in one direction, W/sr
};

// A place that is lit. normal: of the side that light is wanted on, unit length; zero: both.
struct LitPlace {
  Vec3 point{0.0}, normal{0.0};
};

class LightTree {
 public:
  void build(std::vector<LightBounds> lights);  // none with an intensity of 0
  bool empty() const { return nodes_.empty(); }

  // A light for u in [0, 1), with the probability that it is taken with; 0: none can reach the place.
  size_t choose(double u, const LitPlace& place, double& probability) const;
  double probability(size_t light, const LitPlace& place) const;

 private:
  static constexpr int kCut = 16;  // nodes

  struct Node {
    Vec3 centre, axis;
    double radius;                 // of a ball around all
    double cos_normals, sin_normals, cos_emission, intensity;
    uint32_t second;               // the second child; the first one follows the node. A leaf: 0
    uint32_t end;                  // after the last node below this one
    uint32_t light;                // of a leaf

    double importance(const LitPlace& place) const;
    bool near(const LitPlace& place) const;  // and not a leaf
  };
  struct Item {
    LightBounds bounds;
    uint32_t light;
  };
  struct Cut {
    uint32_t nodes[kCut];
    double importance[kCut];
    int size;

    double total() const;
  };
  void build(std::vector<Item>& items, size_t begin, size_t end, int depth);
  Cut cut(const LitPlace& place) const;
  double share_of_first(uint32_t node, const LitPlace& place) const;

  std::vector<Node> nodes_;
  std::vector<uint32_t> leaves_;  // of each light
};

}  // namespace tilecast
