// KTX 2.0 specification, appendices "BasisLZ Global Data" and "BasisLZ/ETC1S Bitstream"; what a block shows: Khronos
// Data Format Specification 1.3, "ETC1S".
#include <algorithm>
#include <array>
#include <vector>

#include "gles/packed/basis_bits.hpp"
#include "gles/packed/ktx2.hpp"

namespace kasumi {

namespace {

// One colour, lighter and darker by a row of the table.
struct Etc1sEndpoint {
  std::array<std::uint8_t, 3> colour{};  // 0 .. 31
  std::uint8_t intensity = 0;            // 0 .. 7
};
// Which of the four shades each pixel has: a row is a byte, its left pixel the lowest two bits.
using Etc1sSelector = std::array<std::uint8_t, 4>;

std::vector<Etc1sEndpoint> read_endpoints(Ktx2Bytes bytes, std::size_t count, bool& whole) {
  BasisBits bits(bytes);
  const std::array<BasisCode, 3> colours{BasisCode(bits), BasisCode(bits), BasisCode(bits)};
  const BasisCode intensities(bits);
  const bool grey = bits.next(1) != 0;
  std::vector<Etc1sEndpoint> endpoints(count);
  Etc1sEndpoint before{{16, 16, 16}, 0};
  for (Etc1sEndpoint& endpoint : endpoints) {
    if (bits.faulty()) break;
    before.intensity = static_cast<std::uint8_t>((before.intensity + intensities.next(bits)) & 7);
    for (std::uint8_t& c : before.colour) {
      if (grey && &c != before.colour.data()) {
        c = before.colour[0];
        continue;
      }
      const BasisCode& code = colours[c < 10 ? 0 : c < 22 ? 1 : 2];
      c = static_cast<std::uint8_t>((c + code.next(bits)) & 31);
    }
    endpoint = before;
  }
  whole = whole && !bits.faulty();
  return endpoints;
}

std::vector<Etc1sSelector> read_selectors(Ktx2Bytes bytes, std::size_t count, bool& whole) {
  BasisBits bits(bytes);
  if (bits.next(2) != 0) bits.fault();
  std::vector<Etc1sSelector> selectors(count);
  const auto plain = [&](Etc1sSelector& selector) {
    for (std::uint8_t& row : selector) row = static_cast<std::uint8_t>(bits.next(8));
  };
  if (bits.next(1) != 0) {
    for (std::size_t i = 0; i < count && !bits.faulty(); ++i) plain(selectors[i]);
  } else {
    const BasisCode code(bits);
    if (count > 0) plain(selectors[0]);
    for (std::size_t i = 1; i < count && !bits.faulty(); ++i)
      for (std::size_t row = 0; row < 4; ++row)
        selectors[i][row] = static_cast<std::uint8_t>(selectors[i - 1][row] ^ code.next(bits));
  }
  whole = whole && !bits.faulty();
  return selectors;
}

// What was used lately, roughly by how often.
class Etc1sHistory {
 public:
  explicit Etc1sHistory(std::size_t size) : values_(size), next_(size / 2) {}
  std::size_t size() const { return values_.size(); }
  void add(std::uint32_t value) {
    if (values_.empty()) return;
    values_[next_++] = value;
    if (next_ == values_.size()) next_ = values_.size() / 2;
  }
  std::uint32_t use(std::size_t place) {
    const std::uint32_t value = values_[place];
    std::swap(values_[place / 2], values_[place]);
    return value;
  }

 private:
  std::vector<std::uint32_t> values_;
  std::size_t next_;
};

// What all slices of a file share.
struct Etc1sBooks {
  explicit Etc1sBooks(BasisBits tables)
      : predictions(tables), deltas(tables), selections(tables), runs(tables), history(tables.next(13)) {
    whole = !tables.faulty();
  }
  BasisCode predictions, deltas, selections, runs;
  std::size_t history;
  bool whole;
  std::vector<Etc1sEndpoint> endpoints;
  std::vector<Etc1sSelector> selectors;
};

// Where each block's endpoint comes from: two bits each, stored once for two by two blocks.
class Etc1sEndpoints {
 public:
  Etc1sEndpoints(const Etc1sBooks& books, std::size_t columns)
      : books_(books), above_(columns), here_(columns), below_((columns + 1) / 2) {}

  // Rows from the top, blocks from the left.
  std::uint32_t next(BasisBits& bits, std::size_t column, std::size_t row) {
    if (column == 0) std::swap(above_, here_);
    if (column % 2 == 0) hints_ = row % 2 == 0 ? next_hints(bits, column) : below_[column / 2];
    const std::uint32_t from = hints_ & 3u;
    hints_ >>= 2;
    if (from == 1) {
      before_ = above_[column];
    } else if (from == 2) {
      if (column == 0) bits.fault();
      before_ = column == 0 ? 0 : above_[column - 1];
    } else if (from == 3) {
      before_ += books_.deltas.next(bits);
      if (before_ >= books_.endpoints.size()) before_ -= static_cast<std::uint32_t>(books_.endpoints.size());
      if (before_ >= books_.endpoints.size()) {
        bits.fault();
        before_ = 0;
      }
    }
    return here_[column] = before_;
  }

 private:
  std::uint32_t next_hints(BasisBits& bits, std::size_t column) {
    constexpr std::uint32_t kAgain = 256, kLeastRun = 3;
    if (run_ > 0) {
      --run_;
    } else if (const std::uint32_t symbol = books_.predictions.next(bits); symbol == kAgain) {
      run_ = std::uint64_t{bits.next_in_chunks(4)} + kLeastRun - 1;
    } else {
      last_ = symbol;
    }
    below_[column / 2] = static_cast<std::uint8_t>(last_ >> 4);
    return last_;
  }

  const Etc1sBooks& books_;
  std::vector<std::uint32_t> above_, here_;
  std::vector<std::uint8_t> below_;
  std::uint32_t hints_ = 0, last_ = 0, before_ = 0;
  std::uint64_t run_ = 0;
};

class Etc1sSelections {
 public:
  explicit Etc1sSelections(const Etc1sBooks& books) : books_(books), history_(books.history) {}

  std::uint32_t next(BasisBits& bits) {
    constexpr std::uint32_t kLeastRun = 3, kLongRun = 63;
    const auto book = static_cast<std::uint32_t>(books_.selectors.size());
    const auto again = book + static_cast<std::uint32_t>(history_.size());
    std::uint32_t symbol = book;
    if (run_ > 0) {
      --run_;
    } else if (symbol = books_.selections.next(bits); symbol == again) {
      const std::uint32_t run = books_.runs.next(bits);
      run_ = std::uint64_t{run == kLongRun ? bits.next_in_chunks(7) : run} + kLeastRun - 1;
      symbol = book;
    }
    if (symbol < book) {
      history_.add(symbol);
      return symbol;
    }
    if (symbol >= again) {
      bits.fault();
      return 0;
    }
    return history_.use(symbol - book);
  }

 private:
  const Etc1sBooks& books_;
  Etc1sHistory history_;
  std::uint64_t run_ = 0;
};

std::array<glm::u8vec4, 4> shades_of(const Etc1sEndpoint& endpoint) {
  constexpr std::array<std::array<int, 2>, 8> kSteps{
      {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};
  const auto [a, b] = kSteps[endpoint.intensity];
  const std::array<int, 4> steps{-b, -a, a, b};
  std::array<glm::u8vec4, 4> shades{};
  shades.fill({0, 0, 0, 255});
  for (std::size_t s = 0; s < 4; ++s)
    for (int c = 0; c < 3; ++c) {
      const int five = endpoint.colour[static_cast<std::size_t>(c)];
      shades[s][c] = static_cast<std::uint8_t>(std::clamp((five << 3 | five >> 2) + steps[s], 0, 255));
    }
  return shades;
}

// Colours, or the transparency, whose green stands for all.
Result<> read_slice(Ktx2Bytes slice, const Etc1sBooks& books, bool transparency, Image<glm::u8vec4>& image) {
  BasisBits bits(slice);
  const int columns = (image.width() + 3) / 4, rows = (image.height() + 3) / 4;
  Etc1sEndpoints endpoints(books, static_cast<std::size_t>(columns));
  Etc1sSelections selections(books);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto endpoint = endpoints.next(bits, static_cast<std::size_t>(column), static_cast<std::size_t>(row));
      const auto selector = selections.next(bits);
      if (bits.faulty())
        return fail(FaultKind::bad_input, "damaged ETC1S picture (block {} of row {})", column + 1, row + 1);
      const auto shades = shades_of(books.endpoints[endpoint]);
      for (int y = 4 * row; y < std::min(4 * row + 4, image.height()); ++y)
        for (int x = 4 * column; x < std::min(4 * column + 4, image.width()); ++x) {
          const int shade = books.selectors[selector][static_cast<std::size_t>(y % 4)] >> (x % 4 * 2) & 3;
          const glm::u8vec4& from = shades[static_cast<std::size_t>(shade)];
          glm::u8vec4& to = image.at(x, y);
          to = transparency ? glm::u8vec4(to.r, to.g, to.b, from.g) : from;
        }
    }
  return {};
}

}  // namespace

Result<Image<glm::u8vec4>> read_etc1s(Ktx2Bytes global, std::uint64_t images, Ktx2Bytes level, int width, int height) {
  constexpr std::size_t kHeader = 20, kImage = 20;
  constexpr std::uint32_t kNeedsOther = 2;
  const auto damaged = [](std::string_view what) {
    return fail(FaultKind::bad_input, "damaged BasisLZ: its {} are not whole", what);
  };
  if (images < 1 || global.size() < kHeader + kImage || images > (global.size() - kHeader) / kImage)
    return damaged("global data");
  const std::uint64_t books_at = kHeader + kImage * images;
  const auto endpoint_bytes = ktx2_number(global, 4, 4), selector_bytes = ktx2_number(global, 8, 4);
  const auto endpoints = ktx2_part(global, books_at, endpoint_bytes);
  const auto selectors = ktx2_part(global, books_at + endpoint_bytes, selector_bytes);
  const auto tables = ktx2_part(global, books_at + endpoint_bytes + selector_bytes, ktx2_number(global, 12, 4));
  if (!endpoints || !selectors || !tables) return damaged("global data");
  Etc1sBooks books{BasisBits(*tables)};
  books.endpoints = read_endpoints(*endpoints, ktx2_number(global, 0, 2), books.whole);
  books.selectors = read_selectors(*selectors, ktx2_number(global, 2, 2), books.whole);
  if (!books.whole || books.endpoints.empty() || books.selectors.empty()) return damaged("books of colours and shades");
  const auto first = [&](std::size_t at) { return ktx2_number(global, kHeader + at, 4); };
  if ((first(0) & kNeedsOther) != 0)
    return fail(FaultKind::bad_input, "a picture of a film: expected one that stands alone");
  const auto colours = ktx2_part(level, first(4), first(8)), transparency = ktx2_part(level, first(12), first(16));
  if (!colours || colours->empty() || !transparency) return damaged("slices");
  Image<glm::u8vec4> image(width, height);
  if (auto read = read_slice(*colours, books, false, image); !read) return fail(read.error());
  if (transparency->empty()) return image;
  if (auto read = read_slice(*transparency, books, true, image); !read) return fail(read.error());
  return image;
}

}  // namespace kasumi
