// What the operator has told the key about colours: background colours he clicked on, and how far
// round them background reaches (chapter 4.3, equations 1 and 2). One file a camera:
//
//   format = "touchline-key-colours"
//   version = 1
//   r1 = 14.0
//   r2 = 28.0
//   background = ["#3a7d2c", "#41862f"]   # in the order of the clicks
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "shared/image/frame.h"

namespace touchline::key {

struct ColourTraining {
  static constexpr std::size_t kMost = 256;  // prototypes

  double r1 = 14;  // R'G'B' distance, 8-bit code values, within which all is background; 1..200
  double r2 = 28;  // and beyond which nothing is; above r1, at most 400
  std::vector<image::Rgb8> background;  // prototypes, in the order of the clicks; at most kMost

  // A click on a background pixel. Every click counts for undo(), a colour that is there already as
  // well. False when there are kMost prototypes.
  bool click(image::Rgb8 colour);
  // Takes the last click back; false when there is none.
  bool undo();

  base::Status validate() const;
  bool operator==(const ColourTraining&) const = default;
};

std::string to_text(const ColourTraining& training);
// `file` names the text in errors. Errors: not this format or version, a colour that is none, radii
// out of bounds, too many prototypes.
base::Result<ColourTraining> parse_colour_training(std::string_view text, const std::string& file);

base::Result<ColourTraining> load_colour_training(const std::filesystem::path& path);
// A file that is there is replaced whole or not at all. Errors: kIo.
base::Status save_colour_training(const std::filesystem::path& path,
                                  const ColourTraining& training);

// "#3a7d2c", and back; nothing for other text.
std::string colour_text(image::Rgb8 colour);
std::optional<image::Rgb8> colour_of(std::string_view text);

// The mean colour of the 3 by 3 pixels round a clicked one, which noise moves less than one pixel;
// pixels beyond the border are left out. Errors: outside the frame.
base::Result<image::Rgb8> colour_at(const image::Frame& frame, int x, int y);

}  // namespace touchline::key
