// How much light rough surfaces reflect and transmit in all, by the angle: what their scattering functions need to
// give back the light that meets more than one microfacet, which those functions by themselves lose.
//
// Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 courses. The integrals are done
// over the microfacets that are seen, where the integrand is bounded by 1.
#pragma once

#include <vector>

#include "base/guide.h"
#include "base/vec.h"

namespace tilecast {

// A function of the cosine of an angle, a parabola in each of its panels.
class EnergyTable {
 public:
  // What a rough surface that reflects all of the light loses by leaving out what is reflected more than once.
  static EnergyTable conductor_loss(double roughness);
  // The same of a dielectric, reflected and transmitted. eta: index of refraction behind over in front.
  static EnergyTable dielectric_loss(double roughness, double eta);
  // What a dielectric reflects, once; roughness 0: by Fresnel's equations.
  static EnergyTable coat_reflection(double roughness, double eta);

  double at(double cosine) const;
  // Over the hemisphere, by the cosine: 2 integral of at(c) c dc, exactly that of the interpolated function.
  double average() const { return average_; }

 private:
  template <class Function>
  EnergyTable(const Function& function, double layer, double kink);

  struct Panel {
    double inverse_width, value, rise, bend;
  };
  std::vector<Panel> panels_;
  std::vector<double> starts_;
  Guide guide_;  // to where the panels after the first start
  double average_ = 0.0;
};

struct SideEnergy {
  EnergyTable loss;
  double transmitted;  // of what is lost, the share that is given back on the other side
};
struct DielectricEnergy {
  SideEnergy front, back;
};
struct CoatEnergy {
  EnergyTable reflection;
  double inner;  // the share of diffuse light from below that is reflected back down
};

DielectricEnergy dielectric_energy(double roughness, double eta);
CoatEnergy coat_energy(double roughness, double eta);

// The reflectance of a conductor over the hemisphere, by the cosine.
double average_reflectance(double eta, double k);

}  // namespace tilecast
