#include <fmt/format.h>

#include <array>
#include <set>

#include "hub/session/schema_internal.h"

namespace touchline::session {
namespace {

using base::ErrorKind;

constexpr const char* kTables = R"(
  CREATE TABLE session(
    name TEXT NOT NULL, sport TEXT NOT NULL,
    length_m REAL, width_m REAL, in_goal_m REAL, crown_m REAL, line_m REAL,
    rate_num INTEGER NOT NULL, rate_den INTEGER NOT NULL, start_timecode TEXT NOT NULL,
    start_ns INTEGER, tolerance_ns INTEGER NOT NULL, finished INTEGER NOT NULL);
  CREATE TABLE camera(
    ordinal INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, role TEXT NOT NULL, side TEXT NOT NULL,
    width INTEGER NOT NULL, height INTEGER NOT NULL);
  CREATE TABLE view(
    camera INTEGER NOT NULL, epoch INTEGER NOT NULL, sequence INTEGER NOT NULL,
    media_time_ns INTEGER NOT NULL,
    segment INTEGER NOT NULL, offset INTEGER NOT NULL, length INTEGER NOT NULL,
    PRIMARY KEY(camera, epoch, sequence)) WITHOUT ROWID;
  CREATE TABLE plate(
    camera INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL,
    epoch INTEGER NOT NULL, version INTEGER NOT NULL,
    segment INTEGER NOT NULL, offset INTEGER NOT NULL, length INTEGER NOT NULL,
    PRIMARY KEY(camera, tile_column, tile_row, epoch, version)) WITHOUT ROWID;
  CREATE TABLE event(
    time_ns INTEGER NOT NULL, camera TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL);
)";

constexpr std::array kSports{std::pair{pitch::Sport::kSoccer, "soccer"},
                             std::pair{pitch::Sport::kRugbyUnion, "rugby"}};
constexpr std::array kRoles{recording::Role::kMatch, recording::Role::kFixed,
                            recording::Role::kCloseup};
constexpr std::array kSides{recording::Side::kMain, recording::Side::kReverse,
                            recording::Side::kLeft, recording::Side::kRight};

template <typename T, std::size_t kCount>
bool from_name(const std::array<T, kCount>& all, const std::string& text, T& value) {
  for (const T one : all) {
    if (recording::name(one) != text) continue;
    value = one;
    return true;
  }
  return false;
}

void bind(Statement& statement, const std::optional<double>& value) {
  if (value) {
    statement.bind(*value);
  } else {
    statement.bind_null();
  }
}

std::optional<double> optional_real(const Statement& statement, int column) {
  if (statement.is_null(column)) return std::nullopt;
  return statement.real(column);
}

base::Error damaged(const std::filesystem::path& file, std::string what) {
  return {ErrorKind::kFormat, file.string(), std::move(what),
          "the index is damaged; use a copy of the session"};
}

base::Status insert_info(Database& database, const SessionInfo& info) {
  auto insert = database.prepare("INSERT INTO session VALUES(?,?,?,?,?,?,?,?,?,?,?,?,0)");
  if (!insert) return base::fail(insert.error());
  insert->bind(info.name);
  for (const auto& [sport, text] : kSports) {
    if (sport == info.sport) insert->bind(std::string(text));
  }
  for (const std::optional<double>& size :
       {info.sizes.length_m, info.sizes.width_m, info.sizes.in_goal_m, info.sizes.crown_m,
        info.sizes.line_m}) {
    bind(*insert, size);
  }
  insert->bind(info.rate.num).bind(info.rate.den).bind(base::to_string(info.start_timecode));
  if (info.start) {
    insert->bind(info.start->ns);
  } else {
    insert->bind_null();
  }
  insert->bind(info.tolerance_ns);
  if (insert->step() != Statement::Step::kDone) return base::fail(database.error("writing"));
  return {};
}

base::Status insert_cameras(Database& database, const SessionInfo& info) {
  auto insert = database.prepare("INSERT INTO camera VALUES(?,?,?,?,?,?)");
  if (!insert) return base::fail(insert.error());
  std::int64_t ordinal = 0;
  for (const SessionCamera& camera : info.cameras) {
    insert->reset();
    insert->bind(ordinal++)
        .bind(camera.id.value)
        .bind(std::string(recording::name(camera.role)))
        .bind(std::string(recording::name(camera.side)))
        .bind(std::int64_t{camera.width})
        .bind(std::int64_t{camera.height});
    if (insert->step() != Statement::Step::kDone) return base::fail(database.error("writing"));
  }
  return {};
}

base::Status read_cameras(const Database& database, const std::filesystem::path& file,
                          SessionInfo& info) {
  auto select =
      database.prepare("SELECT id, role, side, width, height FROM camera ORDER BY ordinal");
  if (!select) return base::fail(select.error());
  auto step = select->step();
  for (; step == Statement::Step::kRow; step = select->step()) {
    SessionCamera camera;
    camera.id.value = select->text(0);
    camera.width = static_cast<int>(select->integer(3));
    camera.height = static_cast<int>(select->integer(4));
    if (!from_name(kRoles, select->text(1), camera.role) ||
        !from_name(kSides, select->text(2), camera.side)) {
      return base::fail(damaged(file, "camera of an unknown role or side"));
    }
    info.cameras.push_back(std::move(camera));
  }
  if (step == Statement::Step::kError) return base::fail(database.error("reading"));
  return {};
}

}  // namespace

base::Status check(const SessionInfo& info) {
  const auto wrong = [](std::string field, std::string what) {
    return base::fail(ErrorKind::kArgument, std::move(field), std::move(what));
  };
  if (info.rate.num <= 0 || info.rate.den <= 0 || info.rate.num > 1'000'000 ||
      info.rate.den > 1'000'000) {
    return wrong("rate", fmt::format("{}/{} frames a second", info.rate.num, info.rate.den));
  }
  if (info.tolerance_ns < 0) return wrong("tolerance_ns", fmt::format("{}", info.tolerance_ns));
  std::set<base::CameraId> seen;
  for (const SessionCamera& camera : info.cameras) {
    if (!base::is_valid(camera.id)) return wrong("camera", "'" + camera.id.value + "' is no name");
    if (!seen.insert(camera.id).second) return wrong(camera.id.value, "configured twice");
    if (camera.width < 0 || camera.height < 0) {
      return wrong(camera.id.value, fmt::format("size {}x{}", camera.width, camera.height));
    }
  }
  return {};
}

base::Status write_schema(Database& database, const SessionInfo& info) {
  base::Status status = database.run("BEGIN");
  if (status) {
    status = database.run(fmt::format("PRAGMA application_id={}; PRAGMA user_version={}",
                                      kApplicationId, kSessionFormatVersion)
                              .c_str());
  }
  if (status) status = database.run(kTables);
  if (status) status = insert_info(database, info);
  if (status) status = insert_cameras(database, info);
  if (status) status = database.run("COMMIT");
  return status;
}

base::Result<SessionInfo> read_info(const Database& database, const std::filesystem::path& file) {
  const auto application = database.number("PRAGMA application_id");
  if (!application) return base::fail(application.error());
  if (*application != kApplicationId) return base::fail(damaged(file, "not a session's index"));
  const auto version = database.number("PRAGMA user_version");
  if (!version) return base::fail(version.error());
  if (*version != kSessionFormatVersion) {
    return base::fail(
        ErrorKind::kUnsupported, file.string(),
        fmt::format("session format {}, this program reads {}", *version, kSessionFormatVersion),
        "use the version of Touchline that wrote it");
  }
  auto select = database.prepare(
      "SELECT name, sport, length_m, width_m, in_goal_m, crown_m, line_m, rate_num, rate_den, "
      "start_timecode, start_ns, tolerance_ns FROM session");
  if (!select) return base::fail(select.error());
  if (select->step() != Statement::Step::kRow) {
    return base::fail(damaged(file, "no information about the session"));
  }
  SessionInfo info;
  info.name = select->text(0);
  bool known = false;
  for (const auto& [sport, text] : kSports) {
    if (select->text(1) != text) continue;
    info.sport = sport;
    known = true;
  }
  if (!known) return base::fail(damaged(file, "unknown sport '" + select->text(1) + "'"));
  info.sizes = {optional_real(*select, 2), optional_real(*select, 3), optional_real(*select, 4),
                optional_real(*select, 5), optional_real(*select, 6)};
  info.rate = {select->integer(7), select->integer(8)};
  const auto timecode = base::parse_timecode(select->text(9));
  if (!timecode) return base::fail(damaged(file, to_string(timecode.error())));
  info.start_timecode = *timecode;
  if (!select->is_null(10)) info.start = base::MediaTime{select->integer(10)};
  info.tolerance_ns = select->integer(11);
  if (const base::Status status = read_cameras(database, file, info); !status) {
    return base::fail(status.error());
  }
  if (const base::Status status = check(info); !status) {
    return base::fail(damaged(file, to_string(status.error())));
  }
  return info;
}

}  // namespace touchline::session
