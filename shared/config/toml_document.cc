#include "shared/config/toml_document.h"

#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <type_traits>

namespace touchline::config {

struct TableNode {
  const toml::table* table = nullptr;  // null: not in the file
  std::string path;                    // "camera[1]"; empty for the root
  std::uint32_t line = 0;
  std::set<std::string, std::less<>> asked;
  std::map<std::string, TableNode*, std::less<>> tables;

  const toml::node* find(std::string_view key) const { return table ? table->get(key) : nullptr; }
  std::string key_path(std::string_view key) const {
    return path.empty() ? std::string(key) : path + "." + std::string(key);
  }
};

struct DocumentState {
  std::string file;
  toml::table toml;
  std::deque<TableNode> nodes;  // addresses stay
  struct Complaint {
    std::uint32_t line;
    base::Error error;
  };
  std::vector<Complaint> complaints;

  TableNode* add(const toml::table* table, std::string path, std::uint32_t fallback_line) {
    TableNode& node = nodes.emplace_back();
    node.table = table;
    node.path = std::move(path);
    node.line = table && table->source().begin ? table->source().begin.line : fallback_line;
    return &node;
  }
  std::string at(std::uint32_t line) const {
    return line > 0 ? file + ":" + std::to_string(line) : file;
  }
  void complain(std::uint32_t line, std::string what, std::string cure) {
    complaints.push_back({line, base::Error{base::ErrorKind::kConfiguration, at(line),
                                            std::move(what), std::move(cure)}});
  }
};

namespace {

constexpr std::uintmax_t kMostBytes = 4 << 20;

std::string_view kind_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

template <typename T>
std::string number_text(T value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(12);
  out << value;
  return out.str();
}

template <typename T>
std::string bounds_text(const Bounds<T>& bounds) {
  const bool least = bounds.least != std::numeric_limits<T>::lowest();
  const bool most = bounds.most != std::numeric_limits<T>::max();
  if (least && most) {
    return "give a value from " + number_text(bounds.least) + " to " + number_text(bounds.most);
  }
  if (least) return "give a value of at least " + number_text(bounds.least);
  return "give a value of at most " + number_text(bounds.most);
}

std::uint32_t line_of(const toml::node& node, const TableNode& table) {
  return node.source().begin ? node.source().begin.line : table.line;
}

void complain_kind(DocumentState& state, const TableNode& table, std::string_view key,
                   const toml::node& node, std::string_view wanted) {
  state.complain(
      line_of(node, table),
      table.key_path(key) + ": is " + std::string(kind_name(node)) + ", not " + std::string(wanted),
      {});
}

template <typename T>
std::optional<T> in_bounds(DocumentState& state, const TableNode& table, std::string_view key,
                           const toml::node& node, T value, const Bounds<T>& bounds) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) {
      state.complain(line_of(node, table),
                     table.key_path(key) + ": " + number_text(value) + " is not a finite number",
                     {});
      return std::nullopt;
    }
  }
  if (value < bounds.least || value > bounds.most) {
    state.complain(line_of(node, table),
                   table.key_path(key) + ": " + number_text(value) + " is out of bounds",
                   bounds_text(bounds));
    return std::nullopt;
  }
  return value;
}

std::optional<double> as_number(DocumentState& state, const TableNode& table, std::string_view key,
                                const toml::node& node, const Bounds<double>& bounds) {
  double value = 0;
  if (const auto* real = node.as_floating_point()) {
    value = real->get();
  } else if (const auto* whole = node.as_integer()) {
    value = static_cast<double>(whole->get());
  } else {
    complain_kind(state, table, key, node, "a number");
    return std::nullopt;
  }
  return in_bounds(state, table, key, node, value, bounds);
}

// Marks the key as asked for; null when it is not in the file.
const toml::node* ask(TableNode& table, std::string_view key) {
  table.asked.emplace(key);
  return table.find(key);
}

void complain_unknown(DocumentState& state, const TableNode& table) {
  if (!table.table) return;
  for (const auto& [key, node] : *table.table) {
    if (table.asked.contains(key.str())) continue;
    const std::uint32_t line = key.source().begin ? key.source().begin.line : line_of(node, table);
    std::string known;
    for (const std::string& word : table.asked) known += (known.empty() ? "" : ", ") + word;
    state.complain(line, table.key_path(key.str()) + ": unknown key",
                   known.empty() ? "remove it" : "known here: " + known);
  }
}

}  // namespace

Table::Table(std::shared_ptr<DocumentState> state, TableNode* node)
    : state_(std::move(state)), node_(node) {}

bool Table::present() const { return node_->table != nullptr; }
bool Table::has(std::string_view key) const { return node_->find(key) != nullptr; }

bool Table::boolean(std::string_view key, bool fallback) {
  const toml::node* node = ask(*node_, key);
  if (!node) return fallback;
  if (const auto* value = node->as_boolean()) return value->get();
  complain_kind(*state_, *node_, key, *node, "true or false");
  return fallback;
}

std::optional<std::int64_t> Table::optional_integer(std::string_view key,
                                                    Bounds<std::int64_t> bounds) {
  const toml::node* node = ask(*node_, key);
  if (!node) return std::nullopt;
  if (const auto* value = node->as_integer()) {
    return in_bounds(*state_, *node_, key, *node, value->get(), bounds);
  }
  complain_kind(*state_, *node_, key, *node, "an integer");
  return std::nullopt;
}

std::optional<double> Table::optional_number(std::string_view key, Bounds<double> bounds) {
  const toml::node* node = ask(*node_, key);
  if (!node) return std::nullopt;
  return as_number(*state_, *node_, key, *node, bounds);
}

std::optional<std::string> Table::optional_text(std::string_view key) {
  const toml::node* node = ask(*node_, key);
  if (!node) return std::nullopt;
  if (const auto* value = node->as_string()) return value->get();
  complain_kind(*state_, *node_, key, *node, "a text");
  return std::nullopt;
}

std::int64_t Table::integer(std::string_view key, std::int64_t fallback,
                            Bounds<std::int64_t> bounds) {
  return optional_integer(key, bounds).value_or(fallback);
}

double Table::number(std::string_view key, double fallback, Bounds<double> bounds) {
  return optional_number(key, bounds).value_or(fallback);
}

std::string Table::text(std::string_view key, std::string_view fallback) {
  auto value = optional_text(key);
  return value ? std::move(*value) : std::string(fallback);
}

std::vector<double> Table::numbers(std::string_view key, std::vector<double> fallback,
                                   Bounds<double> bounds) {
  const toml::node* node = ask(*node_, key);
  if (!node) return fallback;
  const toml::array* array = node->as_array();
  if (!array) {
    complain_kind(*state_, *node_, key, *node, "an array of numbers");
    return fallback;
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string item = std::string(key) + "[" + std::to_string(i) + "]";
    const auto value = as_number(*state_, *node_, item, *array->get(i), bounds);
    if (!value) return fallback;
    values.push_back(*value);
  }
  return values;
}

std::vector<std::string> Table::texts(std::string_view key, std::vector<std::string> fallback) {
  const toml::node* node = ask(*node_, key);
  if (!node) return fallback;
  const toml::array* array = node->as_array();
  if (!array) {
    complain_kind(*state_, *node_, key, *node, "an array of texts");
    return fallback;
  }
  std::vector<std::string> values;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const auto* value = array->get(i)->as_string();
    if (!value) {
      complain_kind(*state_, *node_, std::string(key) + "[" + std::to_string(i) + "]",
                    *array->get(i), "a text");
      return fallback;
    }
    values.push_back(value->get());
  }
  return values;
}

std::int64_t Table::required_integer(std::string_view key, Bounds<std::int64_t> bounds) {
  if (!has(key)) missing(key);
  return optional_integer(key, bounds).value_or(0);
}

double Table::required_number(std::string_view key, Bounds<double> bounds) {
  if (!has(key)) missing(key);
  return optional_number(key, bounds).value_or(0);
}

std::string Table::required_text(std::string_view key) {
  if (!has(key)) missing(key);
  return optional_text(key).value_or("");
}

Table Table::table(std::string_view key) {
  const toml::node* node = ask(*node_, key);
  const toml::table* table = node ? node->as_table() : nullptr;
  if (node && !table) complain_kind(*state_, *node_, key, *node, "a table");
  auto [place, fresh] = node_->tables.try_emplace(std::string(key), nullptr);
  if (fresh) place->second = state_->add(table, node_->key_path(key), node_->line);
  return Table(state_, place->second);
}

std::vector<Table> Table::tables(std::string_view key) {
  const toml::node* node = ask(*node_, key);
  std::vector<Table> result;
  if (!node) return result;
  const toml::array* array = node->as_array();
  if (!array) {
    complain_kind(*state_, *node_, key, *node, "an array of tables");
    return result;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string item = std::string(key) + "[" + std::to_string(i) + "]";
    const toml::table* table = array->get(i)->as_table();
    if (!table) {
      complain_kind(*state_, *node_, item, *array->get(i), "a table");
      continue;
    }
    auto [place, fresh] = node_->tables.try_emplace(item, nullptr);
    if (fresh) place->second = state_->add(table, node_->key_path(item), node_->line);
    result.push_back(Table(state_, place->second));
  }
  return result;
}

void Table::missing(std::string_view key) {
  node_->asked.emplace(key);
  state_->complain(node_->line, node_->key_path(key) + ": missing", "add the key");
}

void Table::reject(std::string_view key, const std::string& what, const std::string& cure) {
  const toml::node* node = node_->find(key);
  state_->complain(node ? line_of(*node, *node_) : node_->line, node_->key_path(key) + ": " + what,
                   cure);
}

Document::Document(std::shared_ptr<DocumentState> state) : state_(std::move(state)) {}

base::Result<Document> Document::load(const std::filesystem::path& path) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) {
    return base::fail(base::ErrorKind::kConfiguration, path.string(), "there is no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    return base::fail(base::ErrorKind::kConfiguration, path.string(), "is not a file");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (!code && size > kMostBytes) {
    return base::fail(base::ErrorKind::kConfiguration, path.string(),
                      "has " + std::to_string(size) + " bytes",
                      "a TOML file may have " + std::to_string(kMostBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) {
    return base::fail(base::ErrorKind::kConfiguration, path.string(), "cannot be read",
                      "check its permissions");
  }
  return parse(text, path.string());
}

base::Result<Document> Document::parse(std::string_view text, const std::string& file) {
  if (text.size() > kMostBytes) {
    return base::fail(base::ErrorKind::kConfiguration, file,
                      "has " + std::to_string(text.size()) + " bytes",
                      "a TOML file may have " + std::to_string(kMostBytes));
  }
  auto state = std::make_shared<DocumentState>();
  state->file = file;
  toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    const toml::parse_error& error = parsed.error();
    return base::fail(base::ErrorKind::kConfiguration, state->at(error.source().begin.line),
                      std::string(error.description()), "correct the TOML");
  }
  state->toml = std::move(parsed).table();
  TableNode* root = state->add(&state->toml, "", 0);
  root->line = 0;
  return Document(std::move(state));
}

Table Document::root() const { return Table(state_, &state_->nodes.front()); }

base::Status Document::finish() const {
  DocumentState sorted{state_->file, {}, {}, state_->complaints};
  for (const TableNode& node : state_->nodes) complain_unknown(sorted, node);
  if (sorted.complaints.empty()) return {};
  const auto first = std::min_element(sorted.complaints.begin(), sorted.complaints.end(),
                                      [](const auto& a, const auto& b) { return a.line < b.line; });
  return base::fail(first->error);
}

}  // namespace touchline::config
