// OpenCV writes to std::cerr why a picture could not be decoded; whoever asked for it reports that in Kasumi's words.
#pragma once

#include <iostream>
#include <streambuf>

namespace kasumi {

// While one lives, what its thread writes to std::cerr is left out; other threads' errors go where they went.
class SilencedErrors {
 public:
  SilencedErrors() {
    static Gate* const kGate = new Gate(std::cerr.rdbuf());  // std::cerr outlives every static object: never deleted
    (void)kGate;
    ++silenced();
  }
  ~SilencedErrors() { --silenced(); }
  SilencedErrors(const SilencedErrors&) = delete;
  SilencedErrors& operator=(const SilencedErrors&) = delete;

 private:
  static int& silenced() {
    thread_local int count = 0;
    return count;
  }

  class Gate final : public std::streambuf {
   public:
    explicit Gate(std::streambuf* behind) : behind_(behind) { std::cerr.rdbuf(this); }

   protected:
    int_type overflow(int_type c) override {
      return silenced() > 0 || traits_type::eq_int_type(c, traits_type::eof()) ? traits_type::not_eof(c)
                                                                               : behind_->sputc(static_cast<char>(c));
    }
    std::streamsize xsputn(const char* text, std::streamsize length) override {
      return silenced() > 0 ? length : behind_->sputn(text, length);
    }
    int sync() override { return silenced() > 0 ? 0 : behind_->pubsync(); }

   private:
    std::streambuf* behind_;
  };
};

}  // namespace kasumi
