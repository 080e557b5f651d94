// Text and numbers for HTML.
#pragma once

#include <string>
#include <string_view>

namespace touchline::score::page {

// &, <, >, " and ' as entities.
std::string escaped(std::string_view text);
// With that many decimals; a dash for NaN.
std::string figure(double value, int decimals);
// Letters, digits, '-' and '_' alone: for ids and file names.
std::string plain(std::string_view text);

}  // namespace touchline::score::page
