#include "base/picture_files/film_encoder.hpp"

#include <cstdint>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "base/c_ptr.hpp"

namespace kasumi {

namespace {

// Against x264's own preset a third of the time and no larger; its quality is x264's usual one.
constexpr const char* kPreset = "veryfast";
constexpr const char* kQuality = "23";
constexpr int kMpeg4Quality = 3;              // of 1 (best) to 31
constexpr int kLargestDenominator = 65'535;   // MPEG-4's, of a frame's duration
constexpr int kFramesBetweenKeyFrames = 250;  // x264's own; MPEG-4's would be 12

void free_codec(AVCodecContext* codec) {
  avcodec_free_context(&codec);
}
void free_frame(AVFrame* frame) {
  av_frame_free(&frame);
}
void free_packet(AVPacket* packet) {
  av_packet_free(&packet);
}
void free_container(AVFormatContext* container) {
  if (container->pb) avio_closep(&container->pb);
  avformat_free_context(container);
}

std::string text_of_error(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = "";
  av_strerror(error, text, sizeof text);
  return text;
}

class LibavFilm final : public FilmEncoder {
 public:
  // false: not with this codec.
  bool open(const char* codec_name, const std::string& file, double frames_per_second, cv::Size size) {
    const AVCodec* codec = avcodec_find_encoder_by_name(codec_name);
    AVFormatContext* container = nullptr;
    if (!codec || avformat_alloc_output_context2(&container, nullptr, nullptr, file.c_str()) < 0) return false;
    container_.reset(container);
    codec_.reset(avcodec_alloc_context3(codec));
    packet_.reset(av_packet_alloc());
    frame_.reset(av_frame_alloc());
    if (!codec_ || !packet_ || !frame_ || !open_codec(*codec, frames_per_second, size)) return false;
    stream_ = avformat_new_stream(container, nullptr);
    if (!stream_ || avcodec_parameters_from_context(stream_->codecpar, codec_.get()) < 0) return false;
    stream_->time_base = codec_->time_base;
    stream_->avg_frame_rate = codec_->framerate;
    // Else a name like "10:30.mp4" is a protocol's.
    if (avio_open(&container->pb, ("file:" + file).c_str(), AVIO_FLAG_WRITE) < 0) return false;
    if (avformat_write_header(container, nullptr) < 0) return false;
    to_yuv_.reset(sws_getContext(size.width, size.height, AV_PIX_FMT_RGB24, size.width, size.height, codec_->pix_fmt,
                                 SWS_BICUBIC, nullptr, nullptr, nullptr));
    return to_yuv_ != nullptr;
  }

  std::string write(const cv::Mat& rgb) override {
    av_frame_unref(frame_.get());  // x264 may still hold the last one's pixels
    frame_->format = codec_->pix_fmt;
    frame_->width = codec_->width;
    frame_->height = codec_->height;
    if (const int error = av_frame_get_buffer(frame_.get(), 0); error < 0) return text_of_error(error);
    const std::uint8_t* rows[] = {rgb.data};
    const int strides[] = {static_cast<int>(rgb.step)};
    sws_scale(to_yuv_.get(), rows, strides, 0, rgb.rows, frame_->data, frame_->linesize);
    frame_->pts = pictures_++;
    return encode(frame_.get());
  }

  std::string finish() override {
    if (auto wrong = encode(nullptr); !wrong.empty()) return wrong;
    if (const int error = av_write_trailer(container_.get()); error < 0) return text_of_error(error);
    const int error = avio_closep(&container_->pb);
    return error < 0 ? text_of_error(error) : "";
  }

 private:
  bool open_codec(const AVCodec& codec, double frames_per_second, cv::Size size) {
    codec_->width = size.width;
    codec_->height = size.height;
    codec_->framerate = av_d2q(frames_per_second, kLargestDenominator);
    codec_->time_base = av_inv_q(codec_->framerate);
    codec_->pix_fmt = AV_PIX_FMT_YUV420P;
    codec_->thread_count = 0;  // as many as the machine is good for
    codec_->gop_size = kFramesBetweenKeyFrames;
    if (container_->oformat->flags & AVFMT_GLOBALHEADER) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    av_opt_set(codec_->priv_data, "preset", kPreset, 0);
    if (av_opt_set(codec_->priv_data, "crf", kQuality, 0) < 0) {
      codec_->flags |= AV_CODEC_FLAG_QSCALE;
      codec_->global_quality = kMpeg4Quality * FF_QP2LAMBDA;
    }
    return avcodec_open2(codec_.get(), &codec, nullptr) >= 0;
  }

  // What is wrong; empty: nothing. `frame`: null: there are no more.
  std::string encode(const AVFrame* frame) {
    if (const int error = avcodec_send_frame(codec_.get(), frame); error < 0) return text_of_error(error);
    for (;;) {
      int error = avcodec_receive_packet(codec_.get(), packet_.get());
      if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return "";
      if (error < 0) return text_of_error(error);
      packet_->duration = 1;
      av_packet_rescale_ts(packet_.get(), codec_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      error = av_interleaved_write_frame(container_.get(), packet_.get());
      if (error >= 0) error = container_->pb->error;  // a full disk shows there
      if (error < 0) return text_of_error(error);
    }
  }

  CPtr<AVFormatContext, free_container> container_;
  CPtr<AVCodecContext, free_codec> codec_;
  CPtr<AVPacket, free_packet> packet_;
  CPtr<AVFrame, free_frame> frame_;
  CPtr<SwsContext, sws_freeContext> to_yuv_;
  AVStream* stream_ = nullptr;  // the container's
  std::int64_t pictures_ = 0;
};

}  // namespace

std::unique_ptr<FilmEncoder> encode_film(const std::string& file, double frames_per_second, cv::Size size) {
  av_log_set_level(AV_LOG_QUIET);  // callers report errors themselves
  for (const char* codec : {"libx264", "mpeg4"}) {
    auto film = std::make_unique<LibavFilm>();
    if (film->open(codec, file, frames_per_second, size)) return film;
  }
  return nullptr;
}

}  // namespace kasumi
