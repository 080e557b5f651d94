// TOML files as option structs: typed getters that know where each key stands, bounds, and unknown
// keys as errors.
//
//   auto document = config::Document::load(path);
//   if (!document) return base::fail(document.error());
//   config::Table key = document->root().table("key");
//   options.n_px = key.number("n_px", options.n_px, {0.0, 20.0});
//   if (auto status = document->finish(); !status) return base::fail(status.error());
//
// A getter that finds a wrong type, a wrong value or a missing key notes it and returns its
// fallback; finish() reports. All errors are of kind kConfiguration; where = "file:line", what
// starts with the key's path, e.g. "camera[1].role".
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/base/result.h"

namespace touchline::config {

// Both ends included.
template <typename T>
struct Bounds {
  T least = std::numeric_limits<T>::lowest();
  T most = std::numeric_limits<T>::max();
};

struct DocumentState;
struct TableNode;

// One table of a document; copies refer to the same table, which lives as long as any of them.
class Table {
 public:
  // False for a table that is not in the file; its getters all return their fallbacks.
  bool present() const;
  bool has(std::string_view key) const;

  bool boolean(std::string_view key, bool fallback);
  std::int64_t integer(std::string_view key, std::int64_t fallback,
                       Bounds<std::int64_t> bounds = {});
  // Takes integers as well; infinities and NaN are refused.
  double number(std::string_view key, double fallback, Bounds<double> bounds = {});
  std::string text(std::string_view key, std::string_view fallback);
  std::vector<double> numbers(std::string_view key, std::vector<double> fallback,
                              Bounds<double> bounds = {});
  std::vector<std::string> texts(std::string_view key, std::vector<std::string> fallback);

  // Absent keys stay absent.
  std::optional<std::int64_t> optional_integer(std::string_view key,
                                               Bounds<std::int64_t> bounds = {});
  std::optional<double> optional_number(std::string_view key, Bounds<double> bounds = {});
  std::optional<std::string> optional_text(std::string_view key);

  // Absent keys are errors; the value is then 0 or empty.
  std::int64_t required_integer(std::string_view key, Bounds<std::int64_t> bounds = {});
  double required_number(std::string_view key, Bounds<double> bounds = {});
  std::string required_text(std::string_view key);

  // One of a list of words.
  template <typename E>
  using Choices = std::initializer_list<std::pair<std::string_view, E>>;
  template <typename E>
  E choice(std::string_view key, E fallback, Choices<E> choices) {
    const auto word = optional_text(key);
    return word ? chosen(key, *word, fallback, choices) : fallback;
  }
  template <typename E>
  E required_choice(std::string_view key, E fallback, Choices<E> choices) {
    if (!has(key)) {
      missing(key);
      return fallback;
    }
    return choice(key, fallback, choices);
  }

  Table table(std::string_view key);                // [key]
  std::vector<Table> tables(std::string_view key);  // [[key]], in the file's order

  // For checks of the caller's own: notes an error at `key`, or at the table where the key is not
  // in the file.
  void reject(std::string_view key, const std::string& what, const std::string& cure = {});

 private:
  friend class Document;
  Table(std::shared_ptr<DocumentState> state, TableNode* node);
  template <typename E>
  E chosen(std::string_view key, const std::string& word, E fallback, Choices<E> choices) {
    std::string words;
    for (const auto& [text, value] : choices) {
      if (text == word) return value;
      words += (words.empty() ? "" : ", ") + std::string(text);
    }
    reject(key, "'" + word + "' is not known", "one of: " + words);
    return fallback;
  }
  void missing(std::string_view key);

  std::shared_ptr<DocumentState> state_;
  TableNode* node_;
};

class Document {
 public:
  // At most 4 MiB.
  static base::Result<Document> load(const std::filesystem::path& path);
  // `file` names the text in errors.
  static base::Result<Document> parse(std::string_view text, const std::string& file);

  Table root() const;
  // What is wrong, the first in the order of the file: what getters noted, and every key that no
  // getter asked for.
  base::Status finish() const;

 private:
  explicit Document(std::shared_ptr<DocumentState> state);
  std::shared_ptr<DocumentState> state_;
};

}  // namespace touchline::config
