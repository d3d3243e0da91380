#include "gles/display/window.hpp"

#include <SDL.h>

#include <algorithm>

#include "base/c_ptr.hpp"

namespace kasumi {
namespace {

std::string sdl_reason() {
  const std::string reason = SDL_GetError();
  return reason.empty() ? "no reason given" : reason;
}

// SDL counts the users of its video subsystem itself.
class SdlVideo {
 public:
  static Result<SdlVideo> start() {
    if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0)
      return fail(FaultKind::unsupported, "no window: SDL finds no display ({})", sdl_reason());
    // SDL falls back to drivers that show nothing; these are accepted only if chosen explicitly.
    const std::string driver = SDL_GetCurrentVideoDriver();
    if (SDL_getenv("SDL_VIDEODRIVER") == nullptr && (driver == "offscreen" || driver == "dummy" || driver == "evdev")) {
      SDL_QuitSubSystem(SDL_INIT_VIDEO);
      return fail(FaultKind::unsupported,
                  "no window: SDL finds no display (only its \"{}\" driver, which shows nothing)", driver);
    }
    return SdlVideo();
  }
  SdlVideo(SdlVideo&& other) noexcept : started_(std::exchange(other.started_, false)) {}
  SdlVideo& operator=(SdlVideo&&) = delete;
  SdlVideo(const SdlVideo&) = delete;
  SdlVideo& operator=(const SdlVideo&) = delete;
  ~SdlVideo() {
    if (started_) SDL_QuitSubSystem(SDL_INIT_VIDEO);
  }

 private:
  SdlVideo() = default;
  bool started_ = true;
};

using SdlWindowPtr = CPtr<SDL_Window, SDL_DestroyWindow>;

class SdlWindow final : public Window {
 public:
  SdlWindow(SdlVideo video, SdlWindowPtr window, SDL_GLContext context)
      : video_(std::move(video)), window_(std::move(window)), context_(context), info_(query_gl_info()) {}
  SdlWindow(const SdlWindow&) = delete;
  SdlWindow& operator=(const SdlWindow&) = delete;
  ~SdlWindow() override { SDL_GL_DeleteContext(context_); }

  const GlInfo& info() const override { return info_; }
  Result<> make_current() override {
    if (SDL_GL_MakeCurrent(window_.get(), context_) != 0)
      return fail(FaultKind::device, "the window's context cannot be made current: {}", sdl_reason());
    return {};
  }

  DrawTarget target() const override {
    DrawTarget target;
    SDL_GL_GetDrawableSize(window_.get(), &target.width, &target.height);
    return target;
  }

  bool handle_events() override {
    SDL_Event event;
    while (SDL_PollEvent(&event) != 0) {
      if (event.type == SDL_QUIT) closing_ = true;
      if (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_CLOSE) closing_ = true;
      if (event.type == SDL_KEYDOWN) {
        const SDL_Keycode key = event.key.keysym.sym;
        if (key == SDLK_ESCAPE || key == SDLK_q) closing_ = true;
        if ((key >= SDLK_a && key <= SDLK_z) || (key >= SDLK_0 && key <= SDLK_9)) input_.keys += static_cast<char>(key);
        for (const auto& [arrow, letter] : {std::pair(SDLK_LEFT, '<'), std::pair(SDLK_RIGHT, '>'),
                                            std::pair(SDLK_UP, '^'), std::pair(SDLK_DOWN, 'v')})
          if (key == arrow) input_.keys += letter;
      }
      if ((event.type == SDL_MOUSEBUTTONDOWN || event.type == SDL_MOUSEBUTTONUP) &&
          event.button.button == SDL_BUTTON_LEFT) {
        input_.dragging = event.type == SDL_MOUSEBUTTONDOWN;
        point_at(event.button.x, event.button.y);
      }
      if (event.type == SDL_MOUSEMOTION) point_at(event.motion.x, event.motion.y);
    }
    return !closing_;
  }

  WindowInput take_input() override {
    WindowInput taken = input_;
    input_.keys.clear();
    return taken;
  }

  void show() override { SDL_GL_SwapWindow(window_.get()); }

 private:
  // SDL gives pointer positions in desktop units, which may be several pixels.
  void point_at(int x, int y) {
    int width = 1, height = 1;
    SDL_GetWindowSize(window_.get(), &width, &height);
    const DrawTarget pixels = target();
    input_.x_px = (x + 0.5) * pixels.width / std::max(width, 1);
    input_.y_px = (y + 0.5) * pixels.height / std::max(height, 1);
  }

  SdlVideo video_;
  SdlWindowPtr window_;
  SDL_GLContext context_;
  GlInfo info_;
  bool closing_ = false;
  WindowInput input_;
};

}  // namespace

Result<std::unique_ptr<Window>> open_window(const WindowSpec& options) {
  SDL_SetMainReady();
  auto video = SdlVideo::start();
  if (!video) return fail(video.error());
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_ES);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 2);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 0);
  SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 0);
  SdlWindowPtr window(SDL_CreateWindow(options.title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
                                       options.width, options.height,
                                       SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI));
  if (window == nullptr) return fail(FaultKind::unsupported, "no window: {}", sdl_reason());
  SDL_GLContext context = SDL_GL_CreateContext(window.get());
  if (context == nullptr) return fail(FaultKind::unsupported, "no GLES 2 context for a window: {}", sdl_reason());
  SDL_GL_SetSwapInterval(options.wait_for_refresh ? 1 : 0);
  return std::make_unique<SdlWindow>(std::move(*video), std::move(window), context);
}

}  // namespace kasumi
