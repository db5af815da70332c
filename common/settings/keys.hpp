// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/base/json.hpp"

namespace gabion {

/// Numbers that are allowed: an interval, with the words that an error message uses for it.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< `low` itself is not allowed
  bool high_open = false;
  std::string allowed = {};

  bool holds(double x) const {
    return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high);
  }
};

Range any_number();
Range positive();
Range non_negative();
Range between(double low, double high);  ///< both ends allowed
Range inside(double low, double high);   ///< both ends excluded
Range at_least(double low);
/// The interval as above, described in other words.
Range in_words(Range range, const std::string& allowed);

enum class KeyType {
  number,
  integer,
  boolean,
  text,
  name,    ///< text of 1 to 64 letters, digits, "_" and "-"
  choice,  ///< one of some words
  vector,  ///< numbers, one a dimension of space
  integers,
  texts,
  rows,     ///< list of lists of numbers
  object,   ///< an object with a table of keys
  objects,  ///< list of them
  named_objects
};

/// Meaning of a missing key.
enum class Absence {
  refused,   ///< the key is required
  fallback,  ///< the default of the table
  computed,  ///< a default that follows from other settings: the reading code knows it
  none,      ///< nothing: what the key is for does not act
  empty      ///< an object reads like {}, a list like []
};

/// The key applies where another one of the same object has one of these words, its default
/// included; without words, where that key is given, or not given.
struct Condition {
  std::string key;
  std::vector<std::string> words = {};
  bool given = true;
};

struct KeyTable;

/// All that is to say about a key of a settings file. Made by the functions of namespace key:
///
///     key::number("dt_max", "s", "Largest step.").in(positive()).or_computed("dt")
struct Key {
  std::string name;
  KeyType type = KeyType::number;
  std::string unit;
  std::string sentence;
  Range range = any_number();      ///< numbers, also those of lists
  std::vector<std::string> words;  ///< choices, also those of texts
  std::size_t min_size = 0;        ///< fewest entries of a list
  std::size_t min_width = 0;       ///< smallest width of vectors, integers and rows
  std::size_t max_width = 0;       ///< largest width of these
  bool nullable = false;           ///< null is allowed and means none
  Absence absence = Absence::refused;
  Json fallback;                      ///< default; of a vector: of each component
  std::string computed;               ///< words for the default
  std::vector<Condition> conditions;  ///< all of them have to hold
  std::string circumstances;          ///< conditions outside the object, in words; only code tests
  std::shared_ptr<const KeyTable> table;  ///< keys of objects

  Key in(const Range& allowed) const;
  Key or_else(const Json& value) const;
  Key or_computed(const std::string& words_for_it) const;
  Key or_none() const;
  Key or_empty() const;
  Key or_null() const;  ///< null is allowed beside the other values
  /// Several keys may have one name, each with conditions of its own: the first that applies
  /// counts.
  Key when(const std::string& other, const std::vector<std::string>& its_words) const;
  Key with(const std::string& other) const;
  Key without(const std::string& other) const;
  Key among(const std::vector<std::string>& allowed) const;  ///< allowed texts
  Key only(const std::string& in_words) const;               ///< sets `circumstances`
  Key not_empty(std::size_t size = 1) const;
  Key wide(std::size_t low, std::size_t high) const;
};

/// The keys of one object. Several keys may share a name: with other types, they are alternatives;
/// with other conditions, they take turns.
struct KeyTable {
  std::string name;  ///< unique in a file
  std::string sentence;
  std::vector<Key> keys;
  /// Exactly one key of these has to be given; empty: no such rule.
  std::vector<std::string> one_of = {};
};

/// Makers of keys.
namespace key {

Key number(const std::string& name, const std::string& unit, const std::string& sentence);
Key integer(const std::string& name, const std::string& sentence);
Key boolean(const std::string& name, const std::string& sentence);
Key text(const std::string& name, const std::string& sentence);
Key plain_name(const std::string& sentence);  ///< the key "name"
Key choice(const std::string& name, const std::vector<std::string>& words,
           const std::string& sentence);
Key vector(const std::string& name, const std::string& unit, const std::string& sentence);
Key integers(const std::string& name, const std::string& sentence);
Key texts(const std::string& name, const std::string& sentence);
Key rows(const std::string& name, const std::string& unit, const std::string& sentence);
Key object(const std::string& name, const KeyTable& table, const std::string& sentence);
Key objects(const std::string& name, const KeyTable& table, const std::string& sentence);
Key named_objects(const std::string& name, const KeyTable& table, const std::string& sentence);
/// "$schema" of a file: for editors, without meaning for the programs.
Key schema();

}  // namespace key

/// Whether the conditions of a key of this table hold in an object.
bool applies(const Key& key, const KeyTable& table, const Json& object);

const char* type_name(KeyType type);

}  // namespace gabion
