#include <optional>

#include "bind/bind.h"
#include "render/denominators.h"
#include "render/error_partials.h"
#include "render/sums.h"

using namespace tilecast;

namespace {

using Sums = std::pair<Array<double>, int>;  // and how many samples of each pixel

SampleSums checked(const Sums& sums, py::ssize_t height, py::ssize_t width, const char* name) {
  check_shape(sums.first, {2, height, width, 3}, name);
  if (sums.second < 1) throw py::value_error(std::string(name) + ": there must be at least one sample");
  return {sums.first.data(), sums.second};
}

template <size_t N>
py::array_t<double> to_numpy(const std::array<double, N>& values) {
  return py::array_t<double>(N, values.data());
}

py::array_t<double> copy(const Array<double>& array) {
  return py::array_t<double>(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()), array.data());
}

// Without the interpreter's lock.
template <class Work>
auto unlocked(Work&& work) {
  py::gil_scoped_release release;
  return work();
}

Planes to_planes(const Array<double>& images) {
  const py::ssize_t axes = images.ndim();
  size_t planes = 1;  // of an image without pixels, too
  for (py::ssize_t axis = 0; axis < axes - 2; ++axis) planes *= images.shape(axis);
  Planes out(static_cast<int>(images.shape(axes - 2)), static_cast<int>(images.shape(axes - 1)), planes);
  for (size_t plane = 0; plane < out.count(); ++plane)
    std::copy_n(images.data() + plane * out.pixels, out.pixels, out[plane]);
  return out;
}
// In the shape of `like`.
py::array_t<double> to_images(const Planes& planes, const py::array& like) {
  py::array_t<double> out(std::vector<py::ssize_t>(like.shape(), like.shape() + like.ndim()));
  for (size_t plane = 0; plane < planes.count(); ++plane)
    std::copy_n(planes[plane], planes.pixels, out.mutable_data() + plane * planes.pixels);
  return out;
}

}  // namespace

void bind_error(py::module_& module) {
  module.attr("ERROR_FLOOR") = kErrorFloor;
  module.attr("ERROR_SUMS_OF_KIND") = static_cast<int>(kSumsOfKind);
  module.attr("ERROR_SUMS") = static_cast<int>(kErrorSums);
  module.attr("ERROR_PARTIALS") = std::tuple_size_v<ErrorPartials>;
  module.attr("TAIL_BINS") = kTailBins;
  module.def(
      "error_partials",
      [](const Array<double>& sums, int samples, const std::vector<Sums>& parts,
         const std::optional<Array<double>>& previous) {
        if (samples < 2) throw py::value_error("samples: must be at least 2, got " + std::to_string(samples));
        if (!parts.empty() && parts.size() != 2) throw py::value_error("parts: must be two or none");
        const py::ssize_t height = sums.ndim() == 4 ? sums.shape(1) : -1, width = sums.ndim() == 4 ? sums.shape(2) : -1;
        const SampleSums all = checked({sums, samples}, height, width, "sums");
        std::optional<SampleParts> split;
        if (!parts.empty())
          split = {checked(parts[0], height, width, "parts[0]"), checked(parts[1], height, width, "parts[1]")};
        std::optional<ErrorPartials> before;
        if (previous) {
          before.emplace();
          check_shape(*previous, {static_cast<py::ssize_t>(before->size())}, "previous");
          std::copy_n(previous->data(), before->size(), before->begin());
        }
        return to_numpy(unlocked([&] {
          return error_partials(static_cast<int>(height), static_cast<int>(width), all, split, before);
        }));
      },
      py::arg("sums"), py::arg("samples"), py::arg("parts") = std::vector<Sums>{}, py::arg("previous") = py::none(),
      "What a tile contributes to the estimate at a checkpoint: float64 [ERROR_PARTIALS]. `sums`: float64 [2, h, w, 3], "
      "even and odd samples apart, `samples` (at least 2) in all. `parts`: (sums, samples) of those before the last "
      "range and of those in it. Where one of them has a single sample, what they tell is taken from `previous`, the "
      "partials of the checkpoint before.");
  module.def(
      "add_sums",
      [](const Array<double>& total, const Array<double>& lost, const Array<double>& more) {
        check_shape(lost, {total.shape(), total.shape() + total.ndim()}, "lost");
        check_shape(more, {total.shape(), total.shape() + total.ndim()}, "more");
        py::array_t<double> sum = copy(total), rest = copy(lost);
        add_sums(sum.mutable_data(), rest.mutable_data(), more.data(), static_cast<size_t>(sum.size()));
        return std::pair(sum, rest);
      },
      py::arg("total"), py::arg("lost"), py::arg("more"),
      "(total, lost) with `more` added, float64 of one shape: total + lost is the sum to twice the precision, and the total "
      "is that sum rounded. See core/render/sums.h.");
  module.def(
      "tail_partials",
      [](const Array<double>& a, const Array<double>& b) {
        if (a.size() != b.size()) throw py::value_error("a and b must have the same size");
        return to_numpy(tail_partials({a.data(), static_cast<size_t>(a.size())}, {b.data(), static_cast<size_t>(b.size())}));
      },
      py::arg("a"), py::arg("b"),
      "What a tile's pixels contribute to `tails.tail_share`, float64 [6 * TAIL_BINS]. `a`, `b`: two estimates of each "
      "pixel's relative error, of any shape.");
  module.def(
      "error_weights",
      [](const Array<double>& means, const Array<double>& variances) {
        check_shape(means, {-1, 3, -1, -1}, "means");
        if (means.shape(0) == 0) throw py::value_error("means: there must be those over all samples");
        check_shape(variances, {means.shape(0), 3, means.shape(2), means.shape(3)}, "variances");
        const Planes of_means = to_planes(means), of_variances = to_planes(variances);
        return to_images(unlocked([&] { return error_weights(of_means, of_variances); }), means);
      },
      py::arg("means"), py::arg("variances"),
      "1 / (R^2 + ERROR_FLOOR) of the pixels of an image whose true one, R, is not known, float64 [k, 3, h, w], from their "
      "means and estimated variances, the same shape. First those over all samples; then those over parts of the "
      "samples, by each of which R is found anew. See core/render/denominators.h.");
  module.def("error_weight", py::vectorize(error_weight), py::arg("found"), py::arg("variance"),
             "1 / (R^2 + ERROR_FLOOR) where R is known as `found`, with noise of that variance: of float64 arrays, number by "
             "number. See core/render/denominators.h.");
  module.def(
      "window_mean",
      [](const Array<double>& images) {
        check_shape(images, {-1, -1, -1}, "images");
        const Planes planes = to_planes(images);
        return to_images(unlocked([&] { return window_means(planes, window_counts(planes.height, planes.width, Window::Wide)); }), images);
      },
      py::arg("images"), "The mean over 9 x 9 pixels around each, cut at the edges; float64 [c, h, w].");
}
