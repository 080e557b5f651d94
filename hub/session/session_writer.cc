#include "hub/session/session_writer.h"

#include <fmt/format.h>

#include <map>
#include <system_error>
#include <utility>

#include "hub/session/database_internal.h"
#include "hub/session/record_internal.h"
#include "hub/session/schema_internal.h"
#include "hub/session/segment_internal.h"

namespace touchline::session {
namespace {

using base::ErrorKind;
namespace fs = std::filesystem;

bool is_session_file(const std::string& name) {
  if (name.rfind(kIndexName, 0) == 0) return true;
  return name.rfind("segment-", 0) == 0 && name.size() > 12 &&
         name.compare(name.size() - 4, 4, ".bin") == 0;
}

// An empty folder to write in, emptied of a session where that is wanted.
base::Status prepare(const fs::path& folder, bool overwrite) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::vector<fs::path> old;
  if (!error) {
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      if (!is_session_file(it->path().filename().string())) {
        return base::fail(
            ErrorKind::kArgument, folder.string(),
            fmt::format("holds {}, which is no part of a session", it->path().filename().string()),
            "give an empty or new folder");
      }
      old.push_back(it->path());
    }
  }
  if (!error && !old.empty() && !overwrite) {
    return base::fail(ErrorKind::kArgument, folder.string(), "holds a session already",
                      "give another folder, or ask for it to be overwritten");
  }
  for (const fs::path& file : old) {
    if (!error) fs::remove(file, error);
  }
  if (error) {
    return base::fail(ErrorKind::kIo, folder.string(), "preparing the folder: " + error.message(),
                      "check the folder's permissions");
  }
  return {};
}

}  // namespace

base::Status WriterOptions::validate() const {
  if (segment_bytes < 4096) {
    return base::fail(ErrorKind::kConfiguration, "segment_bytes",
                      fmt::format("{} is below 4096", segment_bytes));
  }
  return {};
}

class SessionWriter::Impl {
 public:
  Impl(const fs::path& folder, const SessionInfo& info, const WriterOptions& options,
       Database database)
      : folder_(folder),
        database_(std::move(database)),
        segments_(std::make_unique<SegmentWriter>(folder, options.segment_bytes)) {
    std::int64_t ordinal = 0;
    for (const SessionCamera& camera : info.cameras) ordinals_[camera.id] = ordinal++;
  }
  // A session that was given up is readable and says that it is not finished.
  ~Impl() { static_cast<void>(close(false)); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  base::Status start(const SessionInfo& info) {
    // NORMAL: a commit is in the page cache, which outlives the process; the disk follows at each
    // checkpoint.
    base::Status status = database_.run(
        "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA temp_store=MEMORY");
    if (status) status = write_schema(database_, info);
    const std::pair<std::optional<Statement>&, const char*> statements[] = {
        {find_view_, "SELECT 1 FROM view WHERE camera=? AND epoch=? AND sequence=?"},
        {add_view_, "INSERT INTO view VALUES(?,?,?,?,?,?,?)"},
        {find_plate_,
         "SELECT 1 FROM plate WHERE camera=? AND tile_column=? AND tile_row=? AND epoch=? AND "
         "version=?"},
        {add_plate_, "INSERT INTO plate VALUES(?,?,?,?,?,?,?,?)"},
        {add_event_, "INSERT INTO event VALUES(?,?,?,?)"}};
    for (const auto& [statement, sql] : statements) {
      if (!status) return status;
      auto prepared = database_.prepare(sql);
      if (prepared) {
        statement.emplace(std::move(*prepared));
      } else {
        status = base::fail(prepared.error());
      }
    }
    return status;
  }

  base::Status append(const codec::EncodedView& view) {
    const auto camera = ordinal(view.id.camera);
    if (!camera) return base::fail(camera.error());
    const auto sequence = static_cast<std::int64_t>(view.id.sequence);
    find_view_->reset();
    find_view_->bind(*camera).bind(std::int64_t{view.id.epoch}).bind(sequence);
    if (const auto known = is_there(*find_view_); !known || *known) return as_status(known);
    return store(RecordKind::kView, pack(view), *add_view_, [&](Statement& row) {
      row.bind(*camera)
          .bind(std::int64_t{view.id.epoch})
          .bind(sequence)
          .bind(view.stamp.media_time.ns);
    });
  }

  base::Status append(const codec::EncodedPlateTile& tile) {
    const auto camera = ordinal(tile.camera);
    if (!camera) return base::fail(camera.error());
    const auto bind_key = [&](Statement& row) {
      row.bind(*camera)
          .bind(std::int64_t{tile.key.column})
          .bind(std::int64_t{tile.key.row})
          .bind(std::int64_t{tile.epoch})
          .bind(std::int64_t{tile.plate_version});
    };
    find_plate_->reset();
    bind_key(*find_plate_);
    if (const auto known = is_there(*find_plate_); !known || *known) return as_status(known);
    return store(RecordKind::kPlateTile, pack(tile), *add_plate_, bind_key);
  }

  base::Status append(const Event& event) {
    if (!segments_) return closed();
    add_event_->reset();
    add_event_->bind(event.time.ns).bind(event.camera.value).bind(event.kind).bind(event.text);
    return run(*add_event_);
  }

  base::Status finish() { return close(true); }

  base::Status close(bool whole) {
    if (!segments_) return {};
    base::Status status = segments_->finish();
    bytes_ = segments_->bytes_written();
    segments_.reset();
    if (status && whole) {
      status = database_.run("PRAGMA synchronous=FULL; UPDATE session SET finished=1;");
    }
    for (auto* statement : {&find_view_, &add_view_, &find_plate_, &add_plate_, &add_event_}) {
      statement->reset();
    }
    if (status) status = database_.run("PRAGMA wal_checkpoint(TRUNCATE)");
    // Fails where a reader is at it; the session is whole all the same, in two files.
    if (status)
      static_cast<void>(database_.run("PRAGMA busy_timeout=0; PRAGMA journal_mode=DELETE"));
    database_ = Database();
    return status;
  }

  std::uint64_t bytes_written() const { return segments_ ? segments_->bytes_written() : bytes_; }

 private:
  base::Status closed() const {
    return base::fail(ErrorKind::kArgument, folder_.string(), "the session is finished");
  }

  base::Result<std::int64_t> ordinal(const base::CameraId& camera) const {
    if (!segments_) return base::fail(closed().error());
    const auto found = ordinals_.find(camera);
    if (found != ordinals_.end()) return found->second;
    return base::fail(ErrorKind::kArgument, camera.value, "is not configured in this session");
  }

  base::Result<bool> is_there(Statement& find) const {
    const auto step = find.step();
    const base::Error error =
        step == Statement::Step::kError ? database_.error("reading") : base::Error{};
    find.reset();
    if (step == Statement::Step::kError) return base::fail(error);
    return step == Statement::Step::kRow;
  }
  static base::Status as_status(const base::Result<bool>& known) {
    if (!known) return base::fail(known.error());
    return {};
  }

  base::Status run(Statement& statement) const {
    const bool done = statement.step() == Statement::Step::kDone;
    const base::Error error = done ? base::Error{} : database_.error("writing");
    statement.reset();
    if (!done) return base::fail(error);
    return {};
  }

  // The payload first, then its row.
  template <typename BindKey>
  base::Status store(RecordKind kind, const std::vector<std::uint8_t>& payload, Statement& row,
                     const BindKey& bind_key) {
    const auto place = segments_->append(kind, payload);
    if (!place) return base::fail(place.error());
    row.reset();
    bind_key(row);
    row.bind(std::int64_t{place->segment})
        .bind(static_cast<std::int64_t>(place->offset))
        .bind(static_cast<std::int64_t>(place->length));
    base::Status status = run(row);
    if (!status) segments_->drop(*place);
    return status;
  }

  fs::path folder_;
  std::map<base::CameraId, std::int64_t> ordinals_;
  Database database_;
  std::unique_ptr<SegmentWriter> segments_;  // none once finished
  std::uint64_t bytes_ = 0;
  std::optional<Statement> find_view_;
  std::optional<Statement> add_view_;
  std::optional<Statement> find_plate_;
  std::optional<Statement> add_plate_;
  std::optional<Statement> add_event_;
};

SessionWriter::SessionWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SessionWriter::SessionWriter(SessionWriter&&) noexcept = default;
SessionWriter& SessionWriter::operator=(SessionWriter&&) noexcept = default;
SessionWriter::~SessionWriter() = default;

base::Result<SessionWriter> SessionWriter::create(const fs::path& folder, const SessionInfo& info,
                                                  const WriterOptions& options) {
  base::Status status = options.validate();
  if (status) status = check(info);
  if (status) status = prepare(folder, options.overwrite);
  if (!status) return base::fail(status.error());
  auto database = Database::open(folder / kIndexName,
                                 SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX);
  if (!database) return base::fail(database.error());
  auto impl = std::make_unique<Impl>(folder, info, options, std::move(*database));
  status = impl->start(info);
  if (!status) return base::fail(status.error());
  return SessionWriter(std::move(impl));
}

base::Status SessionWriter::append(const codec::EncodedView& view) { return impl_->append(view); }
base::Status SessionWriter::append(const codec::EncodedPlateTile& tile) {
  return impl_->append(tile);
}
base::Status SessionWriter::append(const Event& event) { return impl_->append(event); }
base::Status SessionWriter::finish() { return impl_->finish(); }
std::uint64_t SessionWriter::bytes_written() const { return impl_->bytes_written(); }

}  // namespace touchline::session
