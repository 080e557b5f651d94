#include <fmt/format.h>

#include "hub/session/database_internal.h"

namespace touchline::session {

using base::ErrorKind;

base::Result<Database> Database::open(const std::filesystem::path& file, int flags,
                                      const char* uri_parameters) {
  Database database;
  database.file_ = file.string();
  std::string name = file.string();
  if (uri_parameters != nullptr) {
    std::string escaped;
    for (const char letter : name) {
      if (letter == '%' || letter == '?' || letter == '#') {
        escaped += fmt::format("%{:02x}", static_cast<unsigned char>(letter));
      } else {
        escaped += letter;
      }
    }
    name = "file:" + escaped + "?" + uri_parameters;
    flags |= SQLITE_OPEN_URI;
  }
  sqlite3* opened = nullptr;
  const int rc = sqlite3_open_v2(name.c_str(), &opened, flags, nullptr);
  database.database_.reset(opened);
  if (rc != SQLITE_OK) return base::fail(database.error("opening"));
  sqlite3_extended_result_codes(opened, 1);
  sqlite3_busy_timeout(opened, 10'000);
  return database;
}

base::Error Database::error(const char* doing) const {
  sqlite3* const database = database_.get();
  const int code = database == nullptr ? SQLITE_NOMEM : sqlite3_errcode(database);
  const std::string what = fmt::format(
      "{}: {}", doing, database == nullptr ? "out of memory" : sqlite3_errmsg(database));
  switch (code & 0xff) {
    case SQLITE_FULL:
    case SQLITE_IOERR:
      return {ErrorKind::kIo, file_, what,
              "free space on that disk; what was written before stays readable"};
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
    case SQLITE_AUTH:
      return {ErrorKind::kIo, file_, what, "check that the folder exists and its permissions"};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {ErrorKind::kFormat, file_, what, "the index is damaged; use a copy of the session"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorKind::kIo, file_, what, "another program holds the session; try again"};
    default:
      return {ErrorKind::kFormat, file_, what, {}};
  }
}

base::Status Database::run(const char* sql) {
  if (sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    return base::fail(error("writing"));
  }
  return {};
}

base::Result<Statement> Database::prepare(const char* sql) const {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr) != SQLITE_OK) {
    return base::fail(error("preparing"));
  }
  return Statement(statement);
}

base::Result<std::int64_t> Database::number(const char* sql) const {
  auto statement = prepare(sql);
  if (!statement) return base::fail(statement.error());
  if (statement->step() != Statement::Step::kRow) return base::fail(error("reading"));
  return statement->integer(0);
}

Statement& Statement::bind(std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), next_++, value);
  return *this;
}
Statement& Statement::bind(double value) {
  sqlite3_bind_double(statement_.get(), next_++, value);
  return *this;
}
Statement& Statement::bind(const std::string& value) {
  sqlite3_bind_text64(statement_.get(), next_++, value.data(), value.size(), SQLITE_TRANSIENT,
                      SQLITE_UTF8);
  return *this;
}
Statement& Statement::bind_null() {
  sqlite3_bind_null(statement_.get(), next_++);
  return *this;
}

Statement::Step Statement::step() {
  switch (sqlite3_step(statement_.get())) {
    case SQLITE_ROW:
      return Step::kRow;
    case SQLITE_DONE:
      return Step::kDone;
    default:
      return Step::kError;
  }
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  next_ = 1;
}

std::string Statement::text(int column) const {
  const unsigned char* const text = sqlite3_column_text(statement_.get(), column);
  const int n = sqlite3_column_bytes(statement_.get(), column);
  return text == nullptr ? std::string() : std::string(text, text + n);
}

}  // namespace touchline::session
