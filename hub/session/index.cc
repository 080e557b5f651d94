#include <algorithm>
#include <limits>
#include <system_error>

#include "hub/session/index_internal.h"
#include "hub/session/schema_internal.h"

namespace touchline::session {
namespace {

using base::ErrorKind;
namespace fs = std::filesystem;

base::Error damaged(const fs::path& file) {
  return {ErrorKind::kFormat, file.string(), "a row with impossible values",
          "the index is damaged; use a copy of the session"};
}

// Camera, segment, offset and length of a row, checked.
bool get_place(const Statement& row, int from, std::size_t cameras, std::size_t& camera,
               RecordPlace& place) {
  const std::int64_t ordinal = row.integer(0);
  const std::int64_t segment = row.integer(from);
  const std::int64_t offset = row.integer(from + 1);
  const std::int64_t length = row.integer(from + 2);
  if (ordinal < 0 || ordinal >= static_cast<std::int64_t>(cameras) || segment < 0 ||
      segment > std::numeric_limits<std::uint32_t>::max() || offset < 0 ||
      offset > std::int64_t{1} << 60 || length < 0 ||
      length > static_cast<std::int64_t>(kMaxPayloadBytes)) {
    return false;
  }
  camera = static_cast<std::size_t>(ordinal);
  place = {static_cast<std::uint32_t>(segment), static_cast<std::uint64_t>(offset),
           static_cast<std::uint64_t>(length)};
  return true;
}

// Calls `take` for each row of `sql`; it returns false for a row that cannot be.
template <typename Take>
base::Status each_row(const Database& database, const fs::path& file, const char* sql,
                      const Take& take) {
  auto select = database.prepare(sql);
  if (!select) return base::fail(select.error());
  auto step = select->step();
  for (; step == Statement::Step::kRow; step = select->step()) {
    if (!take(*select)) return base::fail(damaged(file));
  }
  if (step == Statement::Step::kError) return base::fail(database.error("reading"));
  return {};
}

base::Result<Index> read_all(Database& database, const fs::path& file) {
  // One transaction, so that the rows are those of one moment while a writer goes on.
  if (base::Status status = database.run("BEGIN"); !status) return base::fail(status.error());
  auto info = read_info(database, file);
  if (!info) return base::fail(info.error());
  Index index;
  index.info = std::move(*info);
  const std::size_t cameras = index.info.cameras.size();
  const auto finished = database.number("SELECT finished FROM session");
  if (!finished) return base::fail(finished.error());
  index.finished = *finished == 1;
  base::Status status =
      each_row(database, file,
               "SELECT camera, epoch, sequence, media_time_ns, segment, offset, length FROM view "
               "ORDER BY camera, epoch, sequence",
               [&](const Statement& row) {
                 ViewRow view;
                 view.epoch = static_cast<std::uint32_t>(row.integer(1));
                 view.sequence = static_cast<std::uint64_t>(row.integer(2));
                 view.time.ns = row.integer(3);
                 if (!get_place(row, 4, cameras, view.camera, view.place)) return false;
                 index.views.push_back(view);
                 return true;
               });
  if (status) {
    status = each_row(
        database, file,
        "SELECT camera, tile_column, tile_row, epoch, version, segment, offset, length FROM plate "
        "ORDER BY camera, tile_column, tile_row, epoch, version",
        [&](const Statement& row) {
          PlateRow plate;
          plate.key = {static_cast<std::int32_t>(row.integer(1)),
                       static_cast<std::int32_t>(row.integer(2))};
          plate.epoch = static_cast<std::uint32_t>(row.integer(3));
          plate.version = static_cast<std::uint32_t>(row.integer(4));
          if (!get_place(row, 5, cameras, plate.camera, plate.place)) return false;
          index.plates.push_back(plate);
          return true;
        });
  }
  if (status) {
    status = each_row(
        database, file, "SELECT time_ns, camera, kind, text FROM event", [&](const Statement& row) {
          index.events.push_back({{row.integer(0)}, {row.text(1)}, row.text(2), row.text(3)});
          return true;
        });
  }
  if (!status) return base::fail(status.error());
  std::sort(index.events.begin(), index.events.end());
  return index;
}

bool is_access_error(const base::Error& error) { return error.kind == ErrorKind::kIo; }

}  // namespace

base::Result<Index> read_index(const fs::path& folder) {
  const fs::path file = folder / kIndexName;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    return base::fail(ErrorKind::kNotFound, folder.string(), "no session there",
                      "give the folder that holds index.sqlite");
  }
  // A reader of a WAL index needs its shared-memory file beside it. Where that cannot be made (full
  // disk, read-only disk) the index is read alone: exclusively, or, when no log is left over, as
  // it stands.
  base::Result<Index> index = base::fail(ErrorKind::kInternal, file.string(), "not read");
  const auto attempt = [&](int flags, const char* uri, const char* first) {
    auto database = Database::open(file, flags | SQLITE_OPEN_NOMUTEX, uri);
    if (!database) {
      index = base::fail(database.error());
      return;
    }
    if (const base::Status status = database->run(first); !status) {
      index = base::fail(status.error());
      return;
    }
    index = read_all(*database, file);
  };
  attempt(SQLITE_OPEN_READONLY, nullptr, "PRAGMA query_only=1");
  if (!index && is_access_error(index.error())) {
    attempt(SQLITE_OPEN_READWRITE, nullptr, "PRAGMA locking_mode=EXCLUSIVE; PRAGMA query_only=1");
  }
  if (!index && is_access_error(index.error())) {
    const auto log_bytes = fs::file_size(folder / (std::string(kIndexName) + "-wal"), error);
    if (error || log_bytes == 0) {
      attempt(SQLITE_OPEN_READONLY, "immutable=1", "PRAGMA query_only=1");
    }
  }
  return index;
}

}  // namespace touchline::session
