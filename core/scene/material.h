// Materials as plain data.
#pragma once

#include "base/vec.h"

namespace tilecast {

enum class MaterialKind : uint8_t { Diffuse, Mirror, Conductor, Dielectric, Plastic, Phong, Blend };

// A microfacet surface that is smoother than this counts as smooth; so does one between media whose indices of
// refraction differ by a smaller share than this, as it refracts into one direction as far as anyone can see.
inline constexpr double kLeastRoughness = 1e-3, kLeastContrast = 1e-4;
inline bool is_smooth(double roughness) { return roughness < kLeastRoughness; }

struct Material {
  MaterialKind kind = MaterialKind::Diffuse;
  Rgb reflectance{0.8};
  int texture = -1;         // replaces the reflectance; dielectric: the tint
  double roughness = 0.0;   // GGX alpha = roughness^2, 0: smooth; diffuse: of Oren and Nayar's kind
  double ior = 1.5;         // index of refraction; dielectric: of the inside, plastic: of the coat over what is outside
  Rgb absorption{0.0};      // dielectric: per metre
  Rgb emission{0.0};        // radiance, leaves the side that the geometric normal points to
  double opacity = 1.0;     // part of the light that meets the surface; all else goes straight on
  Rgb tint{1.0};            // dielectric: of what goes through its surface, at each passage
  int priority = 0;         // dielectric: where several overlap, the highest counts
  Rgb eta{0.0}, k{0.0};     // conductor: complex index of refraction; eta 0: Schlick's approximation to the reflectance
  Rgb specular{0.2};        // phong
  double exponent = 20.0;   // phong
  double abbe = 0.0;        // dielectric: Abbe's number; 0: no dispersion

  static constexpr int kMostParts = 3;
  int parts[kMostParts] = {-1, -1, -1};  // blend: materials that are no blends
  double shares[kMostParts] = {0, 0, 0};  // blend: of the parts, 1 together

  // Textures instead of the numbers above, whose place these take; -1: none.
  int roughness_texture = -1;  // diffuse, conductor, plastic
  int opacity_texture = -1;
  int emission_texture = -1;   // such an emitter is met by chance alone
  int normal_map = -1;         // of unit vectors about the surface's, with u and v; 0.5 stands for 0

  // Set by the builder. Where there is a texture: opacity is its least value, roughness and emission are its greatest.
  bool textured = false;    // it or a part of it
  bool uses_uv = false;
  int first_level = 0;      // textured roughness: the energy table of the least, in sixteenths
  bool refracts = false;    // light goes through it, into another medium
  double dispersion = 0.0;  // Cauchy's coefficient, see optics/spectrum.h
  int energy = -1;          // rough: its energy table; rough dielectric: the first of its pairs with a medium beside it
  int medium = 0;           // dielectric: number of its index of refraction; 0 is vacuum
  Rgb average{1.0};         // conductor: of the Fresnel reflectance over all directions, by the cosine

  bool emits() const { return max_component(emission) > 0.0; }
  bool smooth() const { return is_smooth(roughness); }
};

}  // namespace tilecast
