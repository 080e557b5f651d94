// SQLite as the session needs it: a connection and statements that clean up after themselves.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "shared/base/result.h"

namespace touchline::session {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

class Statement;

class Database {
 public:
  // `flags` are SQLITE_OPEN_...; `uri` lets the name carry parameters.
  static base::Result<Database> open(const std::filesystem::path& file, int flags,
                                     const char* uri_parameters = nullptr);

  base::Status run(const char* sql);
  base::Result<Statement> prepare(const char* sql) const;
  base::Result<std::int64_t> number(const char* sql) const;  // the first column of the first row
  base::Error error(const char* doing) const;

 private:
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::string file_;
};

// Bind in order, then step; columns are read in order too.
class Statement {
 public:
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(const std::string& value);
  Statement& bind_null();

  enum class Step { kRow, kDone, kError };
  Step step();
  void reset();

  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  double real(int column) const { return sqlite3_column_double(statement_.get(), column); }
  bool is_null(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
  }
  std::string text(int column) const;

 private:
  std::unique_ptr<sqlite3_stmt, FinalizeStatement> statement_;
  int next_ = 1;
};

}  // namespace touchline::session
