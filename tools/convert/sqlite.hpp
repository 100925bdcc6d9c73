// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <sqlite3.h>
#include <string>

namespace slam {

struct CloseSqlite {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseSqlite>;
using Statement = std::unique_ptr<sqlite3_stmt, CloseSqlite>;

/// @return nullptr where the query is none for this database
inline Statement prepare(const Database& database, const std::string& query) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database.get(), query.c_str(), -1, &statement, nullptr);
  return Statement(statement);
}

}  // namespace slam
