// What the core throws. Both become Python exceptions of the same names.
#pragma once

#include <stdexcept>
#include <string>

namespace tilecast {

// Invalid geometry or parameters: says what is wrong and how to mend it.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A NaN or infinite sample: names the pixel, the sample and the seed. Or one that lies in too many media.
struct SampleError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace tilecast
