#include "images/texels.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/texture.h>

#include <atomic>
#include <bit>
#include <cstring>

#include "base/check.h"

namespace tilecast {
namespace {

constexpr int kLargestTile = 256;  // pixels
constexpr size_t kLargestCopied = size_t(1) << 20;  // values
constexpr size_t kCopies = 16;
constexpr float kBrightest = 1e30f;
constexpr size_t kMostPixels = size_t(1) << 25;
constexpr const char* kAddress = "tilecast:pixels";

struct Pixels {
  std::vector<float> values;
  int width, height, channels;
};

// Hands the TextureSystem tiles of what is in memory.
class FromMemory : public OIIO::ImageInput {
 public:
  const char* format_name() const override { return "tilecast"; }
  bool open(const std::string&, OIIO::ImageSpec&) override { return false; }
  bool open(const std::string&, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override {
    void* address = nullptr;
    if (!config.getattribute(kAddress, OIIO::TypeDesc::PTR, &address)) return false;
    pixels_ = static_cast<const Pixels*>(address);
    m_spec = OIIO::ImageSpec(pixels_->width, pixels_->height, pixels_->channels, OIIO::TypeFloat);
    m_spec.tile_width = tile(pixels_->width);
    m_spec.tile_height = tile(pixels_->height);
    m_spec.tile_depth = 1;
    spec = m_spec;
    return true;
  }
  bool close() override { return true; }
  bool read_native_scanline(int, int, int, int, void*) override { return false; }
  bool read_native_tile(int, int, int x, int y, int, void* data) override {
    const int width = m_spec.tile_width, height = m_spec.tile_height;
    const size_t channels = pixels_->channels, columns = std::min(width, pixels_->width - x);
    float* out = static_cast<float*>(data);
    std::fill_n(out, width * height * channels, 0.0f);  // beyond the image nothing is looked up
    for (int row = 0; row < std::min(height, pixels_->height - y); ++row)
      std::memcpy(out + row * width * channels, &pixels_->values[(size_t(y + row) * pixels_->width + x) * channels],
                  columns * channels * sizeof(float));
    return true;
  }

 private:
  static int tile(int size) { return std::min<int>(std::bit_ceil(unsigned(size)), kLargestTile); }

  const Pixels* pixels_ = nullptr;
};

OIIO::ImageInput* make_from_memory() { return new FromMemory; }

OIIO::TextureSystem& texture_system() {
  static OIIO::TextureSystem* const system = OIIO::TextureSystem::create(true);
  return *system;
}
OIIO::ImageCache& image_cache() {
  static OIIO::ImageCache* const cache = OIIO::ImageCache::create(true);  // the one of the texture system
  return *cache;
}

// The TextureSystem remembers the last two tiles of a thread; what is not among them is looked for under a lock. A hit asks
// several images in turn, so each of them has a memory of its own in each thread, or shares it with few others.
class ThreadMemories {
 public:
  ThreadMemories() : thread(count_++) {}
  ~ThreadMemories() {
    for (OIIO::TextureSystem::Perthread* memory : memories_)
      if (memory) texture_system().destroy_thread_info(memory);
  }
  OIIO::TextureSystem::Perthread* of(uint64_t image) {
    OIIO::TextureSystem::Perthread*& memory = memories_[image % std::size(memories_)];
    if (!memory) memory = texture_system().create_thread_info();
    return texture_system().get_perthread_info(memory);
  }

  const uint32_t thread;  // its number

 private:
  inline static std::atomic<uint32_t> count_{0};
  OIIO::TextureSystem::Perthread* memories_[64] = {};
};

class InTextureSystem : public Texels {
 public:
  explicit InTextureSystem(Pixels pixels) : pixels_(std::move(pixels)), number_(next_number()) {
    for (int c = 0; c < 3; ++c) {
      const int channel = pixels_.channels == 1 ? 0 : c;
      least[c] = most[c] = pixels_.values[channel];
      for (size_t i = channel; i < pixels_.values.size(); i += pixels_.channels) {
        least[c] = std::min<double>(least[c], pixels_.values[i]);
        most[c] = std::max<double>(most[c], pixels_.values[i]);
      }
    }
    OIIO::ImageSpec config;
    const void* address = &pixels_;
    config.attribute(kAddress, OIIO::TypeDesc::PTR, &address);
    for (size_t i = 0; i < (pixels_.values.size() <= kLargestCopied ? kCopies : 1); ++i) {
      const OIIO::ustring& name = names_.emplace_back("tilecast:" + std::to_string(number_) + ":" + std::to_string(i));
      image_cache().add_file(name, make_from_memory, &config);
      handles_.push_back(texture_system().get_texture_handle(name));
      if (!handles_.back() || !texture_system().good(handles_.back()))
        throw Error("the image cannot be made a texture: " + texture_system().geterror());
    }
  }
  ~InTextureSystem() override {
    for (OIIO::ustring name : names_) image_cache().invalidate(name, true);
  }
  InTextureSystem(const InTextureSystem&) = delete;
  InTextureSystem& operator=(const InTextureSystem&) = delete;

  Rgb at(const Vec2& st, Wrap wrap, TexelFilter filter) const override {
    if (filter == TexelFilter::Closest) return closest(st, wrap);
    OIIO::TextureOpt options;
    options.swrap = options.twrap = wrap == Wrap::Repeat   ? OIIO::TextureOpt::WrapPeriodic
                                    : wrap == Wrap::Mirror ? OIIO::TextureOpt::WrapMirror
                                                           : OIIO::TextureOpt::WrapClamp;
    options.mipmode = OIIO::TextureOpt::MipModeNoMIP;
    options.interpmode = OIIO::TextureOpt::InterpBilinear;
    float found[3] = {0.0f, 0.0f, 0.0f};
    thread_local ThreadMemories memories;
    texture_system().texture(handles_[memories.thread % handles_.size()], memories.of(number_), options,
                             static_cast<float>(st.x), static_cast<float>(1.0 - st.y), 0.0f, 0.0f, 0.0f, 0.0f,
                             pixels_.channels, found);
    if (pixels_.channels == 1) found[1] = found[2] = found[0];
    return {found[0], found[1], found[2]};
  }

 private:
  // An edge between two belongs to the one that is to the right, or above. The TextureSystem takes the other, and so the
  // last one for the first.
  Rgb closest(const Vec2& st, Wrap wrap) const {
    auto texel = [wrap](double x, int64_t size) -> int64_t {
      int64_t i = static_cast<int64_t>(x * size);
      if (wrap == Wrap::Mirror) i = std::min(i, 2 * size - 1 - i);
      return std::clamp<int64_t>(i, 0, size - 1);  // x just below 1 may have become 1
    };
    const int64_t column = texel(st.x, pixels_.width), row = pixels_.height - 1 - texel(st.y, pixels_.height);
    const float* found = &pixels_.values[(row * pixels_.width + column) * pixels_.channels];
    return pixels_.channels == 1 ? Rgb(found[0]) : Rgb(found[0], found[1], found[2]);
  }
  static uint64_t next_number() {  // never the same twice: nothing that the cache still holds is taken for another's
    static std::atomic<uint64_t> count{0};
    return count++;
  }

  const Pixels pixels_;
  const uint64_t number_;
  // A lookup marks its tile as used, which takes the line from the cores that look up the same one: each thread has a
  // copy of a small image.
  std::vector<OIIO::ustring> names_;
  std::vector<OIIO::TextureSystem::TextureHandle*> handles_;
};

}  // namespace

std::shared_ptr<Texels> make_texels(std::vector<float> pixels, int width, int height, int channels) {
  if (width < 1 || height < 1 || size_t(width) * height > kMostPixels)
    throw Error("a texture has at least 1 and at most 2^25 pixels, got " + std::to_string(width) + " x " +
                std::to_string(height));
  for (size_t i = 0; i < pixels.size(); ++i)
    if (!(std::fabs(pixels[i]) <= kBrightest)) {  // NaN too
      const size_t pixel = i / channels;
      throw Error("pixel (" + std::to_string(pixel % width) + ", " + std::to_string(pixel / width) + ") is " +
                  text(pixels[i]) + ": values must be at most 1e30");
    }
  return std::make_shared<InTextureSystem>(Pixels{std::move(pixels), width, height, channels});
}

}  // namespace tilecast
