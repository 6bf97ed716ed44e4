#include "bench/meshes.h"

#include <fstream>
#include <random>
#include <stdexcept>

namespace tilecast::bench {

Triangles read_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line, header;
  size_t vertices = 0, faces = 0;
  while (std::getline(file, line) && line != "end_header") {
    header += line + "\n";
    std::sscanf(line.c_str(), "element vertex %zu", &vertices);
    std::sscanf(line.c_str(), "element face %zu", &faces);
  }
  auto has = [&](const char* text) { return header.find(text) != std::string::npos; };
  if (!file || !has("binary_little_endian") || !has("property float z\nelement face") || !has("list uchar int"))
    throw std::runtime_error(path + " is not a binary PLY file with float positions alone");
  Triangles out;
  out.name = path.substr(path.find_last_of('/') + 1);
  out.name = out.name.substr(0, out.name.find_last_of('.'));
  for (size_t i = 0; i < vertices; ++i) {
    float p[3];
    file.read(reinterpret_cast<char*>(p), sizeof p);
    out.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (size_t i = 0; i < faces; ++i) {
    glm::uvec3 f;
    if (file.get() != 3) throw std::runtime_error(path + ": a face is not a triangle");
    file.read(reinterpret_cast<char*>(&f.x), sizeof f);
    out.faces.push_back(f);
  }
  if (!file) throw std::runtime_error(path + " ends early");
  return out;
}

Triangles terrain(uint32_t side) {
  auto lattice = [](uint32_t x, uint32_t y, uint32_t octave) {
    uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ octave * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (h ^ h >> 15) * 0x1p-32;
  };
  auto noise = [&](double x, double y, uint32_t octave) {
    uint32_t i = static_cast<uint32_t>(x), j = static_cast<uint32_t>(y);
    double a = x - i, b = y - j;
    a = a * a * (3 - 2 * a), b = b * b * (3 - 2 * b);
    double low = lattice(i, j, octave) * (1 - a) + lattice(i + 1, j, octave) * a;
    double high = lattice(i, j + 1, octave) * (1 - a) + lattice(i + 1, j + 1, octave) * a;
    return low * (1 - b) + high * b;
  };
  Triangles out;
  out.name = "terrain";
  for (uint32_t j = 0; j <= side; ++j)
    for (uint32_t i = 0; i <= side; ++i) {
      double x = double(i) / side, y = double(j) / side, height = 0.0;
      for (uint32_t octave = 0; octave < 7; ++octave) height += 0.25 * noise(x * (4 << octave), y * (4 << octave), octave) / (1 << octave);
      out.vertices.emplace_back(float(2 * x - 1), float(height), float(2 * y - 1));
    }
  for (uint32_t j = 0; j < side; ++j)
    for (uint32_t i = 0; i < side; ++i) {
      uint32_t p = j * (side + 1) + i, q = p + side + 1;
      out.faces.push_back({p, q, p + 1});
      out.faces.push_back({p + 1, q, q + 1});
    }
  return out;
}

Triangles soup(uint32_t count) {
  std::mt19937 random(1);
  auto unit = [&] { return std::uniform_real_distribution<float>(-1, 1)(random); };
  Triangles out;
  out.name = "soup";
  for (uint32_t i = 0; i < count; ++i) {
    Vec3 centre{unit(), unit(), unit()};
    for (int k = 0; k < 3; ++k) {
      Vec3 p = centre + 0.01 * Vec3{unit(), unit(), unit()};
      out.vertices.emplace_back(float(p.x), float(p.y), float(p.z));
    }
    out.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return out;
}

}  // namespace tilecast::bench
