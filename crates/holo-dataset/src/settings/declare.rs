//! The macros that declare settings: [`settings!`](declare) for a group of settings, [`words!`](declare) for the names of
//! an enum.

/// Declares a group of settings: a struct with its defaults, and one [`Setting`](super::Setting) for every row.
///
/// `of GET, GET_MUT` are functions that return the group of a `RenderSettings`, or `None` where its camera has none of
/// them. The doc comment of a row is its help. A row is one of:
///
/// | row | field |
/// |---|---|
/// | `name: Type = default, "key" "FORM";` | a value; `bool` is a flag |
/// | `name: Option<Type>, "key" "FORM";` | a value that may be missing |
/// | `off name, "no-key";` | `bool`, true unless the flag is given |
/// | `one_of name: Enum = default => { setter: Variant(Type), "key" "FORM"; .. }` | alternatives, of which one is set |
///
/// `by FUNCTION` after the form replaces the parser of the type.
///
/// Every row is also a method that sets the field; of `one_of` every alternative is one, with a name of its own. The group
/// has these methods. After `setters of OWNER in FIELD;` the struct `OWNER` has them, whose field `FIELD` is the group.
macro_rules! settings {
    (
        setters of $owner:ident in $group:ident;
        $(#[doc = $doc:literal])*
        pub struct $name:ident of $get:ident, $get_mut:ident { $($rows:tt)* }
    ) => {
        settings!(@ $name [$($doc)*] [$owner $group] $get $get_mut {} {} {} {} $($rows)*);
    };
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident of $get:ident, $get_mut:ident { $($rows:tt)* }
    ) => {
        settings!(@ $name [$($doc)*] [$name] $get $get_mut {} {} {} {} $($rows)*);
    };
    (@ $name:ident [$($doc:literal)*] [$owner:ident $($group:ident)?] $get:ident $get_mut:ident
        {$($fields:tt)*} {$($defaults:tt)*} {$($setters:tt)*} {$($table:tt)*}
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct $name { $($fields)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($defaults)* }
            }
        }

        impl $name {
            pub(crate) const TABLE: &[Setting] = &[$($table)*];
        }

        impl $owner {
            $($setters)*
        }
    };
    (@ $name:ident $doc:tt $owner:tt $get:ident $get_mut:ident
        {$($fields:tt)*} {$($defaults:tt)*} {$($setters:tt)*} {$($table:tt)*}
        $(#[doc = $help:literal])*
        $field:ident: Option<$type:ty>, $key:literal $form:literal $(by $parse:path)?; $($rest:tt)*
    ) => {
        settings!(@ $name $doc $owner $get $get_mut
            {$($fields)* $(#[doc = $help])* pub $field: Option<$type>,}
            {$($defaults)* $field: None,}
            {$($setters)* settings!(@some $name $owner $field: $type);}
            {$($table)* Setting {
                key: $key,
                form: $form,
                help: &[$($help),*],
                field: stringify!($field),
                kind: <$type as SettingType>::KIND,
                get: |settings| match $get(settings) {
                    Some(own) => own.$field.as_ref().map_or(ManifestValue::None, SettingType::value),
                    None => ManifestValue::None,
                },
                set: |settings, text| {
                    $get_mut(settings)?.$field = Some(settings!(@parse $type, $($parse)?)(text)?);
                    Ok(())
                },
            },}
            $($rest)*);
    };
    (@ $name:ident $doc:tt $owner:tt $get:ident $get_mut:ident
        {$($fields:tt)*} {$($defaults:tt)*} {$($setters:tt)*} {$($table:tt)*}
        $(#[doc = $help:literal])*
        off $field:ident, $key:literal; $($rest:tt)*
    ) => {
        settings!(@ $name $doc $owner $get $get_mut
            {$($fields)* $(#[doc = $help])* pub $field: bool,}
            {$($defaults)* $field: true,}
            {$($setters)* settings!(@setter $name $owner $field: bool);}
            {$($table)* Setting {
                key: $key,
                form: "",
                help: &[$($help),*],
                field: stringify!($field),
                kind: Kind::Flag,
                get: |settings| $get(settings).map_or(ManifestValue::None, |own| (!own.$field).into()),
                set: |settings, text| {
                    $get_mut(settings)?.$field = !bool::parse(text)?;
                    Ok(())
                },
            },}
            $($rest)*);
    };
    (@ $name:ident $doc:tt $owner:tt $get:ident $get_mut:ident
        {$($fields:tt)*} {$($defaults:tt)*} {$($setters:tt)*} {$($table:tt)*}
        $(#[doc = $field_doc:literal])*
        one_of $field:ident: $enum:ident = $default:expr => {$(
            $(#[doc = $help:literal])*
            $setter:ident: $variant:ident($type:ty), $key:literal $form:literal $(by $parse:path)?;
        )*} $($rest:tt)*
    ) => {
        settings!(@ $name $doc $owner $get $get_mut
            {$($fields)* $(#[doc = $field_doc])* pub $field: $enum,}
            {$($defaults)* $field: $default,}
            {$($setters)* $(settings!(@alternative $name $owner $setter $field $enum::$variant($type));)*}
            {$($table)* $(Setting {
                key: $key,
                form: $form,
                help: &[$($help),*],
                field: stringify!($field),
                kind: <$type as SettingType>::KIND,
                get: |settings| match $get(settings).map(|own| &own.$field) {
                    Some($enum::$variant(value)) => SettingType::value(value),
                    _ => ManifestValue::None,
                },
                set: |settings, text| {
                    $get_mut(settings)?.$field = $enum::$variant(settings!(@parse $type, $($parse)?)(text)?);
                    Ok(())
                },
            },)*}
            $($rest)*);
    };
    (@ $name:ident $doc:tt $owner:tt $get:ident $get_mut:ident
        {$($fields:tt)*} {$($defaults:tt)*} {$($setters:tt)*} {$($table:tt)*}
        $(#[doc = $help:literal])*
        $field:ident: $type:ident $(<$of:ident>)? = $default:expr, $key:literal $form:literal $(by $parse:path)?;
        $($rest:tt)*
    ) => {
        settings!(@ $name $doc $owner $get $get_mut
            {$($fields)* $(#[doc = $help])* pub $field: $type $(<$of>)?,}
            {$($defaults)* $field: $default,}
            {$($setters)* settings!(@given $name $owner $field $type $(<$of>)?);}
            {$($table)* Setting {
                key: $key,
                form: $form,
                help: &[$($help),*],
                field: stringify!($field),
                kind: <$type $(<$of>)? as SettingType>::KIND,
                get: |settings| $get(settings).map_or(ManifestValue::None, |own| SettingType::value(&own.$field)),
                set: |settings, text| {
                    $get_mut(settings)?.$field = settings!(@parse $type $(<$of>)?, $($parse)?)(text)?;
                    Ok(())
                },
            },}
            $($rest)*);
    };
    (@parse $type:ty, $parse:path) => { $parse };
    (@parse $type:ty,) => { <$type as SettingType>::parse };
    // Not `impl Into<u32>`: the compiler takes a literal for an i32 then.
    (@given $name:ident $owner:tt $field:ident u32) => { settings!(@setter $name $owner $field: u32); };
    (@given $name:ident $owner:tt $field:ident u64) => { settings!(@setter $name $owner $field: u64); };
    (@given $name:ident $owner:tt $field:ident $type:ty) => { settings!(@setter $name $owner $field: impl Into<$type>); };
    (@setter $name:ident [$owner:ident $($group:ident)?] $field:ident: $given:ty) => {
        #[doc = concat!("Sets [`", stringify!($name), "::", stringify!($field), "`].")]
        #[must_use]
        pub fn $field(mut self, value: $given) -> Self {
            self.$($group.)?$field = value.into();
            self
        }
    };
    (@some $name:ident [$owner:ident $($group:ident)?] $field:ident: $type:ty) => {
        #[doc = concat!("Sets [`", stringify!($name), "::", stringify!($field), "`].")]
        #[must_use]
        pub fn $field(mut self, value: impl Into<$type>) -> Self {
            self.$($group.)?$field = Some(value.into());
            self
        }
    };
    (@alternative $name:ident [$owner:ident $($group:ident)?] $setter:ident $field:ident
        $enum:ident::$variant:ident($type:ty)
    ) => {
        #[doc = concat!(
            "Sets [`", stringify!($name), "::", stringify!($field), "`] to [`",
            stringify!($enum), "::", stringify!($variant), "`]."
        )]
        #[must_use]
        pub fn $setter(mut self, value: impl Into<$type>) -> Self {
            self.$($group.)?$field = $enum::$variant(value.into());
            self
        }
    };
}

/// Declares the words of an enum: value, name, help.
macro_rules! words {
    ($type:ty: $(($value:expr, $name:literal, $help:literal)),* $(,)?) => {
        impl SettingType for $type {
            const KIND: Kind = Kind::Word(&[$(Word { name: $name, help: $help }),*]);

            fn parse(text: &str) -> Result<Self, Malformed> {
                // The British spelling of version 0.1.0.
                let text = if text == "colour" { "color" } else { text };
                $(if text == $name {
                    return Ok($value);
                })*
                Err(Self::KIND.expected().into())
            }

            fn value(&self) -> ManifestValue {
                $(if *self == $value {
                    return $name.into();
                })*
                ManifestValue::None
            }
        }
    };
}

pub(super) use {settings, words};
