// Result<T>: a value or an Error. Only the part of tl::expected that std::expected has too is used.
#pragma once

#include <tl/expected.hpp>
#include <utility>

#include "shared/base/error.h"

namespace touchline::base {

template <typename T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

inline tl::unexpected<Error> fail(ErrorKind kind, std::string where, std::string what,
                                  std::string cure = {}) {
  return tl::unexpected<Error>(Error{kind, std::move(where), std::move(what), std::move(cure)});
}
inline tl::unexpected<Error> fail(Error error) { return tl::unexpected<Error>(std::move(error)); }

}  // namespace touchline::base
