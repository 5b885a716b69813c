#pragma once

namespace shutterline::test {

/// From now on SQLite's writes go past the installed FileFaults as those of server/files do (under the path
/// "sqlite"). Its flushes cannot be intercepted. To be called before a database is opened.
void LetFaultsSeeSqlite();

}  // namespace shutterline::test
