#include "shared/config/toml_document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/folders.h"

namespace touchline::config {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Document parsed(std::string_view text) {
  auto document = Document::parse(text, "unit.toml");
  EXPECT_TRUE(document) << base::to_string(document.error());
  return *document;
}

// The error that finish() reports; asserts that there is one of the right kind.
base::Error complaint(const Document& document) {
  const auto status = document.finish();
  EXPECT_FALSE(status) << "nothing was reported";
  if (status) return {};
  EXPECT_EQ(status.error().kind, base::ErrorKind::kConfiguration);
  return status.error();
}

TEST(TomlDocument, GivesWhatTheFileSays) {
  const Document document = parsed(R"(
name = "m1"
count = 7
ratio = 0.25
whole = 3
on = true
list = [1, 2.5, 3]
words = ["a", "b"]
mode = "live"
[key]
n_px = 2.0
[[peer]]
host = "x"
[[peer]]
host = "y"
)");
  enum class Mode { kReplay, kLive };
  Table root = document.root();
  EXPECT_EQ(root.required_text("name"), "m1");
  EXPECT_EQ(root.integer("count", 0, {0, 10}), 7);
  EXPECT_EQ(root.number("ratio", 0), 0.25);
  EXPECT_EQ(root.number("whole", 0), 3.0);
  EXPECT_TRUE(root.boolean("on", false));
  EXPECT_THAT(root.numbers("list", {}), ElementsAre(1, 2.5, 3));
  EXPECT_THAT(root.texts("words", {}), ElementsAre("a", "b"));
  EXPECT_EQ(root.choice("mode", Mode::kReplay, {{"replay", Mode::kReplay}, {"live", Mode::kLive}}),
            Mode::kLive);
  EXPECT_EQ(root.table("key").number("n_px", 0), 2.0);
  std::vector<Table> peers = root.tables("peer");
  ASSERT_EQ(peers.size(), 2U);
  EXPECT_EQ(peers[0].required_text("host"), "x");
  EXPECT_EQ(peers[1].required_text("host"), "y");
  EXPECT_TRUE(document.finish());
}

TEST(TomlDocument, AbsentKeysKeepTheirFallback) {
  const Document document = parsed("");
  Table root = document.root();
  EXPECT_EQ(root.integer("a", 4), 4);
  EXPECT_EQ(root.number("b", 0.5), 0.5);
  EXPECT_EQ(root.text("c", "x"), "x");
  EXPECT_FALSE(root.boolean("d", false));
  EXPECT_EQ(root.optional_number("e"), std::nullopt);
  Table absent = root.table("f");
  EXPECT_FALSE(absent.present());
  EXPECT_EQ(absent.integer("g", 9), 9);
  EXPECT_TRUE(root.tables("h").empty());
  EXPECT_TRUE(document.finish());
}

TEST(TomlDocument, UnknownKeyIsNamedWithItsLine) {
  const Document document = parsed("count = 1\n\n[key]\nn_px = 1.0\nn_pz = 2.0\n");
  Table root = document.root();
  root.integer("count", 0);
  root.table("key").number("n_px", 0);
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:5");
  EXPECT_THAT(error.what, HasSubstr("key.n_pz: unknown key"));
  EXPECT_THAT(error.cure, HasSubstr("n_px"));
}

TEST(TomlDocument, UnknownTableIsNamedWithItsLine) {
  const Document document = parsed("count = 1\n[tabel]\nx = 1\n");
  document.root().integer("count", 0);
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:2");
  EXPECT_THAT(error.what, HasSubstr("tabel: unknown key"));
}

TEST(TomlDocument, UnknownKeyInATableOfAnArrayIsNamedWithItsIndex) {
  const Document document = parsed("[[peer]]\nhost = \"x\"\n[[peer]]\nhots = \"y\"\n");
  for (Table& peer : document.root().tables("peer")) peer.optional_text("host");
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:4");
  EXPECT_THAT(error.what, HasSubstr("peer[1].hots"));
}

struct WrongValue {
  const char* name;
  const char* text;
  const char* said;
};

class TomlWrongValue : public testing::TestWithParam<WrongValue> {};

TEST_P(TomlWrongValue, IsNamedWithLineAndKeepsTheFallback) {
  const Document document = parsed(std::string("\n") + GetParam().text + "\n");
  Table root = document.root();
  EXPECT_EQ(root.integer("integer", 3, {0, 10}), 3);
  EXPECT_EQ(root.number("number", 0.5, {0, 1}), 0.5);
  EXPECT_EQ(root.text("text", "x"), "x");
  EXPECT_TRUE(root.boolean("boolean", true));
  EXPECT_EQ(root.choice("choice", 1, {{"one", 1}, {"two", 2}}), 1);
  EXPECT_THAT(root.numbers("numbers", {1}, {0, 5}), ElementsAre(1));
  EXPECT_THAT(root.texts("texts", {"a"}), ElementsAre("a"));
  root.table("table");
  root.tables("tables");
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:2");
  EXPECT_THAT(error.what + " " + error.cure, HasSubstr(GetParam().said));
}

INSTANTIATE_TEST_SUITE_P(
    All, TomlWrongValue,
    testing::Values(WrongValue{"integer_below", "integer = -1", "0 to 10"},
                    WrongValue{"integer_above", "integer = 11", "integer: 11"},
                    WrongValue{"integer_is_real", "integer = 1.5", "is a number, not an integer"},
                    WrongValue{"number_above", "number = 1.25", "number: 1.25"},
                    WrongValue{"number_nan", "number = nan", "finite"},
                    WrongValue{"number_infinite", "number = inf", "finite"},
                    WrongValue{"number_is_text", "number = \"1\"", "is a text, not a number"},
                    WrongValue{"text_is_integer", "text = 1", "is an integer, not a text"},
                    WrongValue{"boolean_is_integer", "boolean = 1", "not true or false"},
                    WrongValue{"choice_unknown", "choice = \"tow\"", "one of: one, two"},
                    WrongValue{"numbers_holds_text", "numbers = [1, \"2\"]", "numbers[1]"},
                    WrongValue{"numbers_out_of_bounds", "numbers = [9]", "numbers[0]: 9"},
                    WrongValue{"numbers_is_number", "numbers = 1", "array of numbers"},
                    WrongValue{"texts_holds_number", "texts = [1]", "texts[0]"},
                    WrongValue{"table_is_text", "table = \"x\"", "not a table"},
                    WrongValue{"tables_is_table", "tables = {}", "not an array of tables"},
                    WrongValue{"text_is_date", "text = 2020-01-01", "date or time"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(TomlDocument, MissingKeyIsNamedWithTheLineOfItsTable) {
  const Document document = parsed("\n[[camera]]\nrole = \"match\"\n");
  Table camera = document.root().tables("camera").at(0);
  camera.optional_text("role");
  EXPECT_EQ(camera.required_text("id"), "");
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:2");
  EXPECT_THAT(error.what, HasSubstr("camera[0].id: missing"));
}

TEST(TomlDocument, FirstErrorOfTheFileComesFirst) {
  const Document document = parsed("unknown = 1\nlate = 99\n");
  document.root().integer("late", 0, {0, 10});
  EXPECT_EQ(complaint(document).where, "unit.toml:1");
}

TEST(TomlDocument, RejectPointsAtTheKey) {
  const Document document = parsed("a = 1\nb = 2\n");
  Table root = document.root();
  root.integer("a", 0);
  root.integer("b", 0);
  root.reject("b", "must be below a", "swap them");
  const base::Error error = complaint(document);
  EXPECT_EQ(error.where, "unit.toml:2");
  EXPECT_EQ(error.what, "b: must be below a");
  EXPECT_EQ(error.cure, "swap them");
}

TEST(TomlDocument, SyntaxErrorIsNamedWithItsLine) {
  const auto document = Document::parse("a = 1\nb = = 2\n", "unit.toml");
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(document.error().where, "unit.toml:2");
}

TEST(TomlDocument, HostileTextIsRefused) {
  for (const char* text : {"[", "[[", "[a", "a = [", "a = {", "a = \"", "\xCB\x86",
                           "a = 1 \xCB\x86", "\xFF", "a = 1e", "a.b.c", "[a]\n[a]\n"}) {
    const auto document = Document::parse(text, "unit.toml");
    ASSERT_FALSE(document) << text;
    EXPECT_EQ(document.error().kind, base::ErrorKind::kConfiguration);
  }
  EXPECT_FALSE(Document::parse(std::string(2000, '[') + std::string(2000, ']'), "unit.toml"));
  EXPECT_FALSE(Document::parse("a = " + std::string(2000, '['), "unit.toml"));
}

TEST(TomlDocument, DuplicateKeyIsNamedWithItsLine) {
  const auto document = Document::parse("a = 1\na = 2\n", "unit.toml");
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().where, "unit.toml:2");
}

TEST(TomlDocument, FileThatIsNotThereIsNamed) {
  const auto document = Document::load("/nowhere/unit.toml");
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(document.error().where, "/nowhere/unit.toml");
}

TEST(TomlDocument, FolderIsNotAFile) {
  const support::TempFolder folder;
  const auto document = Document::load(folder.path());
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().kind, base::ErrorKind::kConfiguration);
}

TEST(TomlDocument, LoadsAFile) {
  const support::TempFolder folder;
  support::write_text(folder / "unit.toml", "a = 5\n");
  const auto document = Document::load(folder / "unit.toml");
  ASSERT_TRUE(document);
  EXPECT_EQ(document->root().integer("a", 0), 5);
  EXPECT_TRUE(document->finish());
}

}  // namespace
}  // namespace touchline::config
